//! glTF 2.0 and GLB (Khronos, glTF 2.0 Specification): the default scene's triangles in the places of their nodes, with
//! materials, lights and cameras. Textures, skins, morph targets and animations are named in notes.

mod accessors;
mod buffers;
mod container;
mod extensions;
mod json;
mod lights;
mod materials;
mod nodes;
mod primitives;
mod textures;

use super::Mesh;
use super::bounds::Bounds;
use super::error::SceneError;
use super::library::Library;
use super::model::{Model, Wanted};
use super::model_file::ModelFile;
use super::notes::Reading;
use accessors::Accessors;
use buffers::Buffers;
use json::Root;
use lights::Punctual;
use materials::Materials;
use nodes::Visit;
use primitives::{LeftOut, Primitives};

/// Reads a glTF or GLB file.
pub(super) fn read(
    file: ModelFile,
    wanted: Wanted,
    library: &mut Library,
    reading: &mut Reading,
) -> Result<Model, SceneError> {
    let (root, bin) = container::open(file)?;
    extensions::check(file, &root, reading)?;
    let visits = nodes::walk(file, &root, wanted.node, reading)?;
    let wanted_meshes = visits.iter().filter(|v| v.wanted).filter_map(|v| root.nodes[v.node].mesh);
    primitives::check_repetitions(file, &root, wanted_meshes)?;
    let mut accessors = Accessors { file, root: &root, buffers: Buffers::new(file, bin, &root) };
    let mut materials = Materials::new(wanted.material);
    let mut primitives = Primitives {
        accessors: &mut accessors,
        materials: &mut materials,
        library,
        left_out: LeftOut::default(),
    };
    let mut flattened = 0;
    let mut meshes: Vec<Mesh> = Vec::new();
    for visit in visits.iter().filter(|v| v.wanted) {
        let Some(mesh) = root.nodes[visit.node].mesh else { continue };
        match wanted.place.after(visit.world) {
            Some(place) => meshes.extend(primitives.mesh(mesh, place, &name(file, &root, visit))?),
            None => flattened += 1,
        }
    }
    let LeftOut { thin, empty, rest, lost } = primitives.left_out;
    let remedy = "export the model again, as triangles";
    file.assume(reading, flattened, "nodes flattened by a scale of 0 are left out", remedy)?;
    file.assume(reading, thin, "primitives of points or lines are left out", remedy)?;
    file.assume(reading, empty, "primitives without positions are left out", remedy)?;
    file.assume(reading, rest, "vertices after the last whole triangle are left out", remedy)?;
    file.assume(reading, lost, "triangles with a corner that is not finite are left out", remedy)?;
    materials.report(file, reading)?;
    moving(file, &root, &visits, reading)?;
    if meshes.is_empty() {
        let part = if wanted.node.is_some() { "this part of the file" } else { "the file's scene" };
        let message = match lost {
            0 => format!("{part} has no triangles"),
            _ => format!("every triangle of {part} has a corner that is not finite"),
        };
        return Err(file.error(message, "export the model again, as a mesh of triangles"));
    }
    let bounds = meshes.iter().fold(Bounds::EMPTY, |b, mesh| b.union(mesh.bounds()));
    let punctual = Punctual { file, root: &root, place: wanted.place, bounds };
    let lights = punctual.lights(&visits, reading)?;
    let cameras = punctual.cameras(&visits, reading)?;
    Ok(Model { meshes, lights, cameras, ..Model::default() })
}

/// What messages call the mesh of a node.
fn name(file: ModelFile, root: &Root, visit: &Visit) -> String {
    format!("{}, {}", file.source.file.display(), nodes::called(root, visit.node))
}

/// Notes what would move: the file is shown as it rests.
fn moving(file: ModelFile, root: &Root, visits: &[Visit], reading: &mut Reading) -> Result<(), SceneError> {
    let nodes = || visits.iter().filter(|v| v.wanted).map(|v| &root.nodes[v.node]);
    let skins = nodes().filter(|node| node.skin.is_some() && node.mesh.is_some()).count();
    let morphs = nodes()
        .filter_map(|node| root.meshes.get(node.mesh?))
        .filter(|mesh| mesh.primitives.iter().any(|p| !p.targets.is_empty()))
        .count();
    let remedy = "export the pose that is wanted, without it";
    file.assume(reading, skins, "skins are left out: meshes stay as they were modelled", remedy)?;
    file.assume(reading, morphs, "morph targets are left out: meshes stay as they were modelled", remedy)?;
    let animated = usize::from(!root.animations.is_empty());
    file.assume(reading, animated, "animations are left out: nodes stay where they rest", remedy)
}

#[cfg(test)]
mod tests;
