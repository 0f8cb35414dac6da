//! The picture of the packages, `docs/packages.svg`, is drawn from the workspace.

use super::{DRAWING, dependencies, read, root};
use std::fmt::Write as _;

const BOX: (usize, usize) = (200, 46);
const GAP: (usize, usize) = (18, 56);
const MARGIN: usize = 44;
const LINE: usize = 33;

/// A package as it is drawn.
struct Package {
    folder: &'static str,
    name: String,
    purpose: String,
    /// The project's packages that it uses, by their place in the list.
    uses: Vec<usize>,
    /// Longest way down to it from a package that none uses.
    row: usize,
}

fn packages() -> Vec<Package> {
    let mut found: Vec<Package> = Vec::new();
    for (folder, _) in DRAWING.iter().filter(|(folder, _)| *folder != "fixtures") {
        let manifest = read(&root().join(folder).join("Cargo.toml"));
        let field = |name: &str| {
            let start = manifest.find(&format!("\n{name} = \"")).expect("a field of a manifest");
            let value = manifest[start..].split('"').nth(1).expect("a value in quotes");
            value.to_owned()
        };
        let uses: Vec<usize> = dependencies(&manifest, "dependencies")
            .iter()
            .filter_map(|name| found.iter().position(|p| p.name == *name))
            .collect();
        found.push(Package {
            folder,
            name: field("name"),
            purpose: field("description"),
            uses,
            row: 0,
        });
    }
    for user in (0..found.len()).rev() {
        for used in found[user].uses.clone() {
            found[used].row = found[used].row.max(found[user].row + 1);
        }
    }
    found
}

/// Leaves out what a package reaches through another one.
fn direct(packages: &[Package], of: usize) -> Vec<usize> {
    let through = |&target: &usize| {
        packages[of].uses.iter().any(|&u| u != target && reaches(packages, u, target))
    };
    packages[of].uses.iter().copied().filter(|u| !through(u)).collect()
}

fn reaches(packages: &[Package], from: usize, to: usize) -> bool {
    from == to || packages[from].uses.iter().any(|&u| reaches(packages, u, to))
}

/// Words of a text in lines of about `LINE` letters, two at most.
fn lines(text: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.last_mut().expect("never empty");
        if !last.is_empty() && last.len() + word.len() >= LINE {
            lines.push(word.to_owned());
        } else {
            let gap = if last.is_empty() { "" } else { " " };
            let _ = write!(last, "{gap}{word}");
        }
    }
    if lines.len() > 2 {
        lines.truncate(2);
        lines[1].push_str(" …");
    }
    lines
}

/// A way past the rows between two packages, along a lane at the side of the picture.
fn around(from: (usize, usize), to: (usize, usize), lane: usize, side: usize) -> String {
    let (out, back) = (from.0 + 6 * lane, to.0 + 6 * lane);
    let (below, above) = (from.1 + 8 + 4 * lane, to.1 - 10 - 4 * lane);
    format!("M{out} {}V{below}H{side}V{above}H{back}V{}", from.1, to.1)
}

/// Places of the packages in the picture.
struct Layout<'a> {
    packages: &'a [Package],
    width: usize,
    height: usize,
}

impl<'a> Layout<'a> {
    fn new(packages: &'a [Package]) -> Self {
        let rows = packages.iter().map(|p| p.row + 1).max().unwrap_or(0);
        let in_row = |row| packages.iter().filter(move |p| p.row == row);
        let widest = (0..rows).map(|row| in_row(row).count()).max().unwrap_or(0);
        Self {
            packages,
            width: widest * (BOX.0 + GAP.0) - GAP.0 + 2 * MARGIN,
            height: rows * (BOX.1 + GAP.1) - GAP.1 + 2 * MARGIN,
        }
    }

    /// The upper left corner of a package's box.
    fn corner(&self, of: usize) -> (usize, usize) {
        let row = self.packages[of].row;
        let count = self.packages.iter().filter(|p| p.row == row).count();
        let place = self.packages[..of].iter().filter(|p| p.row == row).count();
        let left = (self.width - (count * (BOX.0 + GAP.0) - GAP.0)) / 2;
        (left + place * (BOX.0 + GAP.0), MARGIN + row * (BOX.1 + GAP.1))
    }

    /// The way of an arrow; `lanes` are those taken at the left and at the right.
    fn arrow(&self, of: usize, to: usize, lanes: &mut [usize; 2]) -> String {
        let (start, end) = (self.corner(of), self.corner(to));
        let from = (start.0 + BOX.0 / 2, start.1 + BOX.1);
        let to = (end.0 + BOX.0 / 2, end.1 - 2);
        if end.1 - start.1 == BOX.1 + GAP.1 {
            let middle = (from.1 + to.1) / 2;
            let (x, y) = from;
            return format!("M{x} {y}C{x} {middle} {} {middle} {} {}", to.0, to.0, to.1);
        }
        let right = from.0 + to.0 > self.width;
        lanes[usize::from(right)] += 1;
        let lane = lanes[usize::from(right)];
        let side = if right { self.width - MARGIN + 5 * lane } else { MARGIN - 5 * lane };
        around(from, to, lane, side)
    }

    /// The box of a package with its name and its purpose.
    fn package(&self, of: usize) -> String {
        let package = &self.packages[of];
        let (x, y) = self.corner(of);
        let mut svg = format!(
            "<rect x=\"{x}\" y=\"{y}\" width=\"{}\" height=\"{}\" rx=\"5\" fill=\"#eef3fa\" \
             stroke=\"#456\"/><text x=\"{}\" y=\"{}\" font-size=\"12\" \
             font-weight=\"bold\">{}</text>\n",
            BOX.0,
            BOX.1,
            x + 8,
            y + 16,
            package.folder
        );
        for (at, line) in lines(&package.purpose).iter().enumerate() {
            let line = line.replace('&', "&amp;").replace('<', "&lt;");
            let _ = writeln!(svg, "<text x=\"{}\" y=\"{}\">{line}</text>", x + 8, y + 29 + 12 * at);
        }
        svg
    }
}

fn picture() -> String {
    let packages = packages();
    let layout = Layout::new(&packages);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" \
         font-family=\"sans-serif\" font-size=\"10\">\n<title>Packages of lodc: an arrow leads \
         from a package to one that it uses</title>\n<defs><marker id=\"tip\" markerWidth=\"7\" \
         markerHeight=\"7\" refX=\"6\" refY=\"3\" orient=\"auto\"><path d=\"M0 0L6 3L0 6z\" \
         fill=\"#667\"/></marker></defs>\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        layout.width, layout.height
    );
    let mut lanes = [0, 0];
    for of in 0..packages.len() {
        for to in direct(&packages, of) {
            let path = layout.arrow(of, to, &mut lanes);
            let _ = writeln!(
                svg,
                "<path d=\"{path}\" fill=\"none\" stroke=\"#667\" marker-end=\"url(#tip)\"/>"
            );
        }
    }
    (0..packages.len()).for_each(|of| svg.push_str(&layout.package(of)));
    svg + "</svg>\n"
}

/// `UPDATE=1 cargo test -p lodc-fixtures --test architecture picture` (`just drawing`) draws it
/// again.
#[test]
fn picture_of_the_packages_is_that_of_the_workspace() {
    let path = root().join("docs/packages.svg");
    let wanted = picture();
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&path, &wanted).expect("docs/ can be written to");
    }
    assert!(
        std::fs::read_to_string(&path).is_ok_and(|there| there == wanted),
        "docs/packages.svg is not the workspace: run `just drawing` and look at it"
    );
}
