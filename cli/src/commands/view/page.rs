//! Builds the page of `view`: HTML template, CSS, JavaScript modules and the model, joined into one
//! file.

use crate::kinds::UpAxis;
use lodc_lod::interactive::shaders;
use lodc_report::html::{base64, escaped};

const TEMPLATE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");

/// The page's own modules; those of the npm package come before them.
const MODULES: [(&str, &str); 4] = [
    ("viewer.js", include_str!("viewer.js")),
    ("controls.js", include_str!("controls.js")),
    ("exported.js", include_str!("exported.js")),
    ("main.js", include_str!("main.js")),
];

/// The page of a model, a GLB with all levels.
pub(super) fn page(title: &str, up: UpAxis, glb: &[u8]) -> String {
    let modules = lodc_web::MODULES.iter().chain(&MODULES);
    let script: String = modules.map(|(name, text)| without_module_syntax(name, text)).collect();
    let model = base64(glb);
    let mut page = String::with_capacity(model.len() + script.len() + TEMPLATE.len() + STYLE.len());
    let mut rest = TEMPLATE;
    while let Some((before, after)) = rest.split_once("{{") {
        let (key, after_marker) =
            after.split_once("}}").expect("markers of the template are closed");
        page.push_str(before);
        match key {
            "title" => page.push_str(&escaped(title)),
            "up" => page.push_str(if up == UpAxis::Z { "z" } else { "y" }),
            "style" => page.push_str(STYLE),
            "script" => page.push_str(&script),
            "model" => page.push_str(&model),
            "shader" => page.push_str(&view_shader()),
            "version" => page.push_str(env!("CARGO_PKG_VERSION")),
            other => unreachable!("the template has no marker {other}"),
        }
        rest = after_marker;
    }
    page.push_str(rest);
    page
}

/// The kernel that chooses levels by view.
fn view_shader() -> String {
    let shader = shaders::ALL.into_iter().find(|s| s.name == "view");
    shader.expect("views have a kernel").text()
}

/// A module's text for a script of all modules: without its imports and the word `export`.
fn without_module_syntax(name: &str, text: &str) -> String {
    let mut out = format!("// ---- {name}\n");
    let mut in_import = false;
    for line in text.lines() {
        in_import |= line.starts_with("import ");
        if !in_import {
            out.push_str(line.strip_prefix("export ").unwrap_or(line));
            out.push('\n');
        }
        in_import &= !line.ends_with(';');
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_in_a_title_is_markup() {
        let page = page("<b onload=\"x\">&", UpAxis::Y, b"");
        assert!(page.contains("&lt;b onload=&quot;x&quot;&gt;&amp;"));
        assert!(!page.contains("<b onload"));
    }

    #[test]
    fn a_page_needs_no_network_and_no_other_file() {
        let page = page("title", UpAxis::Y, b"glTF");
        for word in ["http:", "https:", "src=", "href=\"/", "\nimport ", "\nexport "] {
            assert!(!page.contains(word), "{word}");
        }
    }
}
