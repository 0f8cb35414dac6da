//! The JavaScript that the npm package and the page of `lodc view` share.

/// Modules by their names in `js/`, each after those that it imports.
pub const MODULES: &[(&str, &str)] = &[
    ("levels.js", include_str!("../js/levels.js")),
    ("glb.js", include_str!("../js/glb.js")),
    ("math.js", include_str!("../js/math.js")),
    ("animation.js", include_str!("../js/animation.js")),
    ("scene.js", include_str!("../js/scene.js")),
    ("order.js", include_str!("../js/order.js")),
    ("normals.js", include_str!("../js/normals.js")),
    ("geometry.js", include_str!("../js/geometry.js")),
    ("selection.js", include_str!("../js/selection.js")),
    ("chainlevels.js", include_str!("../js/chainlevels.js")),
    ("orbit.js", include_str!("../js/orbit.js")),
    ("crowd.js", include_str!("../js/crowd.js")),
    ("motion.js", include_str!("../js/motion.js")),
    ("material.js", include_str!("../js/material.js")),
    ("plan.js", include_str!("../js/plan.js")),
    ("views.js", include_str!("../js/views.js")),
    ("viewdependent.js", include_str!("../js/viewdependent.js")),
    ("glsl.js", include_str!("../js/glsl.js")),
    ("glprogram.js", include_str!("../js/glprogram.js")),
    ("webgl.js", include_str!("../js/webgl.js")),
];
