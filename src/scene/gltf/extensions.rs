//! Which extensions a file may require.

use super::json::Root;
use crate::scene::error::SceneError;
use crate::scene::model_file::{ModelFile, shown, some};
use crate::scene::notes::Reading;

/// Extensions that are read, or that mean nothing to a shape or its colour.
const READ: [&str; 10] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_xmp_json_ld",
    "KHR_animation_pointer",
];

/// Beginnings of the names of extensions that change only how a surface looks: without them the shape is right.
const LOOKS: [&str; 5] =
    ["KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_technique_webgl"];

/// Compressed geometry.
const COMPRESSED: [&str; 3] =
    ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Refuses a file that requires what is not read here.
pub fn check(file: ModelFile, root: &Root, reading: &mut Reading) -> Result<(), SceneError> {
    let mut looks = Vec::new();
    for name in &root.extensions_required {
        if READ.contains(&name.as_str()) {
            continue;
        }
        if LOOKS.iter().any(|start| name.starts_with(start)) {
            looks.push(name);
        } else if COMPRESSED.contains(&name.as_str()) {
            return Err(compressed(file, name));
        } else {
            return Err(file.error(
                format!("it requires the extension `{}`, which is not read", shown(name)),
                "export the model without it",
            ));
        }
    }
    if !looks.is_empty() {
        let message = format!("required extensions that are left out: {}", some(&looks));
        file.assume(reading, 1, &message, "export the model without them")?;
    }
    if root.nodes.iter().any(|node| node.extensions.instances.is_some()) {
        let message = "nodes repeated by EXT_mesh_gpu_instancing are drawn once";
        file.assume(reading, 1, message, "export the model without instances")?;
    }
    Ok(())
}

/// The geometry is compressed by `extension`.
pub fn compressed(file: ModelFile, extension: &str) -> SceneError {
    file.error(
        format!("its geometry is compressed with {extension}, which is not read"),
        "write it without: `npx @gltf-transform/cli@4 copy in.glb out.glb`",
    )
}
