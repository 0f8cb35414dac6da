//! Options that shape a simplification: weights of attributes (`--weight`), parts that stay until
//! the end (`--lock`), and what matters by paint (`--importance`).

use crate::exit::{Failure, Outcome};
use crate::help::SIMPLIFIED;
use crate::jobs::name_list;
use clap::Args;
use lodc::pipeline::Painted;
use lodc_formats::{ObjectInfo, PartNames, Scene};
use lodc_mesh::{Mesh, Semantic};
use lodc_simplify::Weights;
use std::collections::BTreeSet;

/// Weights and locks. They decide the collapse sequence, so a `.lodc` file takes none.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = SIMPLIFIED)]
pub(crate) struct ImportanceArgs {
    /// Importance of attributes: normal=2,uv=0.5,color=1,skin=1,morph=1
    ///
    /// Factors of the defaults, from 0 to 1e6; kinds left out weigh 1.
    #[arg(long, value_name = "LIST", value_parser = weights, hide_short_help = true)]
    weight: Option<Weights>,
    /// Keep border vertices until the terminal phase
    ///
    /// Levels end there, and refitting moves none of them: what is simplified tile by tile meets at
    /// every level.
    #[arg(long, hide_short_help = true)]
    pub(crate) lock_border: bool,
    /// Part that stays: material:NAME, node:NAME or color
    ///
    /// Until the terminal phase. node of an OBJ is the object; color means vertices whose red is 1.
    /// May be given several times.
    #[arg(long, value_name = "PART", value_parser = lock, hide_short_help = true)]
    lock: Vec<Lock>,
    /// Painted importance: a vertex attribute (COLOR_0), or an image (.png, .jpg)
    ///
    /// Its red, from 0 to 1, makes distances there count a tenth (0), as usual (0.5), or ten times
    /// (1), for any metric; stated errors stay what is measured. An image is read at the first
    /// texture coordinates. Objects without them or the attribute count as usual.
    #[arg(long, value_name = "ATTRIBUTE|MAP", hide_short_help = true)]
    importance: Option<String>,
}

/// A part that stays.
#[derive(Clone, Debug, PartialEq)]
enum Lock {
    Material(String),
    Node(String),
    Color,
}

impl ImportanceArgs {
    pub(crate) fn weights(&self) -> Weights {
        self.weight.unwrap_or(Weights::DEFAULT)
    }

    /// Where importance is painted, if it is.
    pub(crate) fn painted(&self) -> Option<Painted> {
        self.importance.as_deref().map(Painted::named)
    }

    /// Refuses weights, paint and locks for an input that has a collapse sequence already.
    ///
    /// # Errors
    /// If there are any.
    pub(crate) fn refuse_for_sequence(&self, input: &str) -> Outcome<()> {
        let is_plain = self.weight.is_none() && self.importance.is_none() && self.lock.is_empty();
        if is_plain && !self.lock_border {
            return Ok(());
        }
        Err(Failure::usage(format!(
            "{input}: its order of collapses is fixed: --weight, --importance, --lock and \
             --lock-border belong to `lodc build`"
        )))
    }

    /// By object and vertex: whether the vertex stays. The list of an object without such vertices
    /// is empty.
    ///
    /// # Errors
    /// If the stored document is damaged, or a lock names nothing in the scene; the message lists
    /// what it has.
    pub(crate) fn locked(&self, scene: &Scene) -> Outcome<Vec<Vec<bool>>> {
        let mut locked = vec![Vec::new(); scene.objects.len()];
        if self.lock.is_empty() {
            return Ok(locked);
        }
        let infos: Vec<&ObjectInfo> = scene.objects.iter().map(|o| &o.info).collect();
        let names = PartNames::new(&scene.document, &infos)?;
        for lock in &self.lock {
            let mut found = false;
            for ((object, list), number) in scene.objects.iter().zip(&mut locked).zip(0..) {
                let chosen = locked_vertices(lock, &object.mesh, &names, number);
                if chosen.contains(&true) {
                    found = true;
                    list.resize(chosen.len(), false);
                    list.iter_mut().zip(chosen).for_each(|(all, one)| *all |= one);
                }
            }
            if !found {
                return Err(unknown_lock(lock, &names));
            }
        }
        Ok(locked)
    }
}

/// By vertex of an object: whether a lock applies to it.
fn locked_vertices(lock: &Lock, mesh: &Mesh, names: &PartNames, object: usize) -> Vec<bool> {
    let is_named = |submesh: usize| match lock {
        Lock::Material(name) => names.materials[object][submesh] == *name,
        Lock::Node(name) => names.nodes[object].contains(name),
        Lock::Color => false,
    };
    let submeshes = mesh.submeshes();
    let by_name: Vec<bool> = (0..submeshes.len()).map(is_named).collect();
    let is_red = |v: u32, submesh: usize| {
        let attributes =
            submeshes[submesh].attributes.iter().map(|&a| &mesh.attributes()[a as usize]);
        let mut colors =
            attributes.filter(|a| a.semantic == Semantic::Color(0) && a.morph_target.is_none());
        *lock == Lock::Color && colors.next().is_some_and(|a| a.value(v, 0) >= 1.0)
    };
    let submesh_of_vertex = mesh.vertex_submesh().iter().map(|&s| s as usize);
    (0..).zip(submesh_of_vertex).map(|(v, s)| by_name[s] || is_red(v, s)).collect()
}

fn unknown_lock(lock: &Lock, names: &PartNames) -> Failure {
    let list = |all: &[Vec<String>]| name_list(all.iter().flatten().map(String::as_str));
    Failure::usage(match lock {
        Lock::Material(name) => {
            format!(
                "--lock: no triangles have the material {name} (there are: {})",
                list(&names.materials)
            )
        }
        Lock::Node(name) => {
            format!("--lock: no node {name} shows a mesh (there are: {})", list(&names.nodes))
        }
        Lock::Color => "--lock color: no vertex has a colour whose red is 1".to_owned(),
    })
}

/// Reads `material:NAME`, `node:NAME` or `color`.
fn lock(text: &str) -> Result<Lock, String> {
    match text.split_once(':') {
        Some(("material", name)) if !name.is_empty() => Ok(Lock::Material(name.to_owned())),
        Some(("node", name)) if !name.is_empty() => Ok(Lock::Node(name.to_owned())),
        None if text == "color" => Ok(Lock::Color),
        _ => Err("material:NAME, node:NAME or color".to_owned()),
    }
}

/// Reads factors by kind: `normal=2,uv=0.5`.
///
/// # Errors
/// If a kind is unknown or given twice, or a factor is not from 0 to 1e6.
pub(crate) fn weights(text: &str) -> Result<Weights, String> {
    let mut weights = Weights::DEFAULT;
    let mut kinds_seen = BTreeSet::new();
    for part in text.split(',') {
        let (kind, number) =
            part.split_once('=').ok_or_else(|| format!("\"{part}\" is not KIND=FACTOR"))?;
        let factor = number.parse::<f64>().ok().filter(|f| (0.0..=1e6).contains(f));
        let factor = factor.ok_or_else(|| format!("\"{part}\": a factor must be from 0 to 1e6"))?;
        let slot = match kind {
            "normal" => &mut weights.normal,
            "uv" => &mut weights.uv,
            "color" => &mut weights.color,
            "skin" => &mut weights.skin,
            "morph" => &mut weights.morph,
            _ => return Err(format!("\"{kind}\" is not one of normal, uv, color, skin, morph")),
        };
        *slot = factor;
        if !kinds_seen.insert(kind) {
            return Err(format!("\"{kind}\" is given twice"));
        }
    }
    Ok(weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_factors_by_kind() {
        let two = weights("normal=2,uv=0.5").expect("two weights");
        assert_eq!(two, Weights { normal: 2.0, uv: 0.5, ..Weights::DEFAULT });
        for wrong in ["", "normal", "normal=-1", "normal=x", "size=1", "uv=1,uv=2", "uv=inf"] {
            assert!(weights(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn locks_name_a_part() {
        assert_eq!(lock("material:red:2"), Ok(Lock::Material("red:2".to_owned())));
        assert_eq!(lock("color"), Ok(Lock::Color));
        for wrong in ["", "material", "material:", "mesh:a", "colour"] {
            assert!(lock(wrong).is_err(), "{wrong}");
        }
    }
}
