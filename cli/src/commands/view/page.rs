//! The page: a template, a style, modules of JavaScript and the model, put into one file.

use crate::html::{base64, escaped};
use lodc_lod::interactive::shaders;

const TEMPLATE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");

/// Modules, each after those that it imports. `crates/web/js` is also what the npm package has.
const MODULES: &[(&str, &str)] = &[
    ("levels.js", include_str!("../../../../crates/web/js/levels.js")),
    ("glb.js", include_str!("../../../../crates/web/js/glb.js")),
    ("math.js", include_str!("../../../../crates/web/js/math.js")),
    ("animation.js", include_str!("../../../../crates/web/js/animation.js")),
    ("scene.js", include_str!("../../../../crates/web/js/scene.js")),
    ("order.js", include_str!("../../../../crates/web/js/order.js")),
    ("normals.js", include_str!("../../../../crates/web/js/normals.js")),
    ("geometry.js", include_str!("../../../../crates/web/js/geometry.js")),
    ("selection.js", include_str!("../../../../crates/web/js/selection.js")),
    ("orbit.js", include_str!("../../../../crates/web/js/orbit.js")),
    ("crowd.js", include_str!("../../../../crates/web/js/crowd.js")),
    ("motion.js", include_str!("../../../../crates/web/js/motion.js")),
    ("material.js", include_str!("../../../../crates/web/js/material.js")),
    ("plan.js", include_str!("../../../../crates/web/js/plan.js")),
    ("views.js", include_str!("../../../../crates/web/js/views.js")),
    ("viewdependent.js", include_str!("../../../../crates/web/js/viewdependent.js")),
    ("glsl.js", include_str!("../../../../crates/web/js/glsl.js")),
    ("glprogram.js", include_str!("../../../../crates/web/js/glprogram.js")),
    ("webgl.js", include_str!("../../../../crates/web/js/webgl.js")),
    ("wgsl.js", include_str!("../../../../crates/web/js/wgsl.js")),
    ("presenter.js", include_str!("../../../../crates/web/js/presenter.js")),
    ("gputextures.js", include_str!("../../../../crates/web/js/gputextures.js")),
    ("gpupipelines.js", include_str!("../../../../crates/web/js/gpupipelines.js")),
    ("webgpu.js", include_str!("../../../../crates/web/js/webgpu.js")),
    ("viewer.js", include_str!("viewer.js")),
    ("controls.js", include_str!("controls.js")),
    ("main.js", include_str!("main.js")),
];

/// The page of a model, a GLB with all levels.
pub(super) fn page(title: &str, glb: &[u8]) -> String {
    let script: String = MODULES.iter().map(|(name, text)| joined(name, text)).collect();
    let model = base64(glb);
    let mut page = String::with_capacity(model.len() + script.len() + TEMPLATE.len() + STYLE.len());
    let mut rest = TEMPLATE;
    while let Some((before, after)) = rest.split_once("{{") {
        let (key, behind) = after.split_once("}}").expect("markers of the template are closed");
        page.push_str(before);
        match key {
            "title" => page.push_str(&escaped(title)),
            "style" => page.push_str(STYLE),
            "script" => page.push_str(&script),
            "model" => page.push_str(&model),
            "shader" => page.push_str(&view_shader()),
            "version" => page.push_str(env!("CARGO_PKG_VERSION")),
            other => unreachable!("the template has no marker {other}"),
        }
        rest = behind;
    }
    page.push_str(rest);
    page
}

/// The kernel that chooses levels by view.
fn view_shader() -> String {
    let shader = shaders::ALL.into_iter().find(|s| s.name == "view");
    shader.expect("views have a kernel").text()
}

/// A module as a part of one script: without its imports and the word `export`.
fn joined(name: &str, text: &str) -> String {
    let mut out = format!("// ---- {name}\n");
    let mut importing = false;
    for line in text.lines() {
        importing |= line.starts_with("import ");
        if !importing {
            out.push_str(line.strip_prefix("export ").unwrap_or(line));
            out.push('\n');
        }
        importing &= !line.ends_with(';');
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_in_a_title_is_markup() {
        let page = page("<b onload=\"x\">&", b"");
        assert!(page.contains("&lt;b onload=&quot;x&quot;&gt;&amp;"));
        assert!(!page.contains("<b onload"));
    }

    #[test]
    fn a_page_needs_no_network_and_no_other_file() {
        let page = page("title", b"glTF");
        for word in ["http:", "https:", "src=", "href=\"/", "\nimport ", "\nexport "] {
            assert!(!page.contains(word), "{word}");
        }
    }
}
