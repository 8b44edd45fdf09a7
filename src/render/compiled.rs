//! The kernels of a scene, compiled and not run. It needs no hardware: a driver's compiler is enough.

use super::RenderError;
use super::precision::Chosen;
use crate::kernel::table::{Kernel, KernelSet};
use crate::plan::explain::form;
use crate::plan::{Plan, PlannedScene, Purpose};
use crate::prepare::Recipe;
use crate::report::compiled::{CompiledKernel, CompiledKernels};
use crate::scene::Scene;
use crate::settings::{DeviceChoice, Precision, Settings};
use crate::vk::{Device, Pipelines};
use std::rc::Rc;

/// Compiles what `scene` needs under `settings`, the kernels for walks that go on included, and asks the driver about
/// it; for its code too if `code`.
///
/// # Errors
/// [`RenderError::NoDevice`] without a device like the one chosen whose driver answers; as
/// [`super::Renderer::prepare`] otherwise.
pub(crate) fn compiled(
    choice: &DeviceChoice,
    scene: &Scene,
    settings: &Settings,
    code: bool,
) -> Result<CompiledKernels, RenderError> {
    let device = Rc::new(Device::inspecting(choice)?);
    let recipe = Recipe::of(scene);
    let near = recipe.local_frame.near.as_ref().filter(|near| !near.single_is_enough(recipe.shape, settings));
    // Absent hardware computes nothing that could be tested.
    let chosen = Chosen { single: &[], sound_double: device.has_double() };
    let (settings, _) = chosen.precision(settings, near.map(|near| (near, recipe.shape)));
    if settings.precision == Precision::Double && !device.has_double() {
        return Err(RenderError::NoDouble { device: device.info().name });
    }
    let limits = device.limits();
    let planned = PlannedScene::with(recipe, scene, &settings, &limits, Purpose::Image, None);
    let plan = planned.plan()?;
    let (always, in_parts) = (plan.kernels(), plan.in_parts());
    let more: Vec<Kernel> = in_parts.kernels().into_iter().filter(|k| !always.contains(k)).collect();
    let mut kernels = of_plan(&device, plan, &always, &settings, code)?;
    let more = of_plan(&device, &in_parts, &more, &settings, code)?;
    kernels.extend(more.into_iter().map(|k| CompiledKernel { in_parts: true, ..k }));
    Ok(CompiledKernels {
        device: device.info(),
        scene: scene.file.display().to_string(),
        workgroup: plan.specialisation.workgroup,
        stack: plan.specialisation.stack_size,
        kernels,
    })
}

fn of_plan(
    device: &Rc<Device>,
    plan: &Plan,
    kernels: &[Kernel],
    settings: &Settings,
    code: bool,
) -> Result<Vec<CompiledKernel>, RenderError> {
    let double = settings.precision == Precision::Double;
    let spec = &plan.specialisation;
    let built = Pipelines::new(device, KernelSet::SHIPPED, kernels.iter().copied(), spec, double)?;
    let one = |kernel: &Kernel| {
        Ok(CompiledKernel {
            kernel: kernel.name().into(),
            form: form(kernel.code(), plan, settings).into(),
            in_parts: false,
            executables: built.executables(*kernel, code)?,
        })
    };
    kernels.iter().map(one).collect()
}
