//! Which device is taken, and why.

use super::candidate::Candidate;
use super::error::VkError;
use super::instance::INSTALL_HINT;
use crate::plan::Driver;
use crate::settings::DeviceChoice;
use std::cmp::Reverse;

/// What devices are compared by. Loaders number devices differently from run to run, so places in their list decide last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Rank {
    /// Place of its kind: hardware with memory of its own first, processors last.
    kind: u8,
    lacks_double: bool,
    /// Drivers that kernels were fitted to come first.
    driver: Driver,
    texels: Reverse<u32>,
    api: Reverse<u32>,
}

impl Rank {
    fn of(c: &Candidate) -> Rank {
        Rank {
            kind: match c.kind() {
                "discrete" => 0,
                "integrated" => 1,
                "virtual" => 2,
                "cpu" => 3,
                _ => 4,
            },
            lacks_double: !c.float64,
            driver: c.measured,
            texels: Reverse(c.limits().texel_elements),
            api: Reverse(c.properties.api_version),
        }
    }
}

/// Usable devices, the most capable first.
fn ranked<'a>(all: impl Iterator<Item = &'a Candidate>) -> Vec<&'a Candidate> {
    let mut usable: Vec<&Candidate> = all.filter(|c| c.lacks().is_none()).collect();
    usable.sort_by_key(|c| Rank::of(c));
    usable
}

/// The most capable of these devices; if none can be used, the first.
fn best<'a>(all: impl Iterator<Item = &'a Candidate> + Clone) -> Option<&'a Candidate> {
    ranked(all.clone()).first().copied().or_else(|| all.clone().next())
}

/// Why `first` is taken before `other`, in words about `first`; both can be used.
pub(super) fn advantage(first: &Candidate, other: &Candidate) -> String {
    let (a, b) = (Rank::of(first), Rank::of(other));
    if a.kind != b.kind {
        let name = |c: &Candidate| match c.kind() {
            "cpu" => "a software device".to_owned(),
            "other" => "a device of another kind".to_owned(),
            kind => format!("{} {kind} GPU", if kind.starts_with('i') { "an" } else { "a" }),
        };
        format!("is {}, this {}", name(first), name(other))
    } else if a.lacks_double != b.lacks_double {
        "computes in f64".into()
    } else if a.driver != b.driver {
        "has the driver that the kernels were measured on".into()
    } else if a.texels != b.texels {
        "has longer texel buffers".into()
    } else if a.api != b.api {
        "has the newer Vulkan".into()
    } else {
        "comes first in the loader's list".into()
    }
}

/// The device for `choice`. `notes` are what is known of drivers that could not be loaded.
pub(super) fn choose(
    all: &[Candidate],
    choice: &DeviceChoice,
    notes: &[String],
) -> Result<Candidate, VkError> {
    let also = notes.iter().map(|note| format!("\n  {note}")).collect::<String>();
    if all.is_empty() {
        return Err(VkError::NoDevice(format!("Vulkan is here, but no device: {INSTALL_HINT}{also}")));
    }
    let names =
        all.iter().enumerate().map(|(i, c)| format!("{i}: {}", c.name)).collect::<Vec<_>>().join("; ");
    let none =
        |what: String| VkError::NoDevice(format!("{what}; there are {names} (see `whitted devices`){also}"));
    let found = match choice {
        DeviceChoice::Best => ranked(all.iter()).first().copied(),
        DeviceChoice::Index(i) => all.get(*i),
        DeviceChoice::Cpu => best(all.iter().filter(|c| c.kind() == "cpu")),
        DeviceChoice::Uuid(uuid) => all.iter().find(|c| c.uuid == *uuid),
        DeviceChoice::Name(name) => {
            let name = name.to_lowercase();
            best(all.iter().filter(|c| c.name.to_lowercase().contains(&name)))
        }
    };
    let found = found.ok_or_else(|| {
        none(match choice {
            DeviceChoice::Best => match all {
                [one] => format!("`{}` cannot be used: {}", one.name, one.lacks().unwrap_or_default()),
                _ => "no device can be used".into(),
            },
            DeviceChoice::Index(i) => format!("there is no device {i}"),
            DeviceChoice::Cpu => "there is no software device".into(),
            DeviceChoice::Uuid(_) => "there is no device with that UUID".into(),
            DeviceChoice::Name(name) => format!("no device's name contains `{name}`"),
        })
    })?;
    match found.lacks() {
        Some(why) => Err(none(format!("`{}` cannot be used: {why}", found.name))),
        None => Ok(found.clone()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ash::vk;

    fn device(name: &str, kind: vk::PhysicalDeviceType, measured: Driver, float64: bool) -> Candidate {
        let mut properties = vk::PhysicalDeviceProperties { device_type: kind, ..Default::default() };
        properties.api_version = vk::API_VERSION_1_3;
        properties.limits.max_texel_buffer_elements = 1 << 16;
        properties.limits.max_per_stage_descriptor_storage_buffers = 32;
        Candidate {
            handle: vk::PhysicalDevice::null(),
            properties,
            subgroup_size: 4,
            shuffles: true,
            driver: name.into(),
            measured,
            uuid: [0; 16],
            heap: 1 << 30,
            allocation: 1 << 30,
            queue_family: Some(0),
            timestamp_bits: 64,
            scalar_layout: true,
            float64,
            name: name.into(),
        }
    }

    fn lavapipe() -> Candidate {
        device("llvmpipe", vk::PhysicalDeviceType::CPU, Driver::Lavapipe, true)
    }

    fn swift_shader() -> Candidate {
        device("SwiftShader", vk::PhysicalDeviceType::CPU, Driver::SwiftShader, false)
    }

    fn chosen(all: &[Candidate], choice: &DeviceChoice) -> String {
        choose(all, choice, &[]).expect("a device").name
    }

    #[test]
    fn the_most_capable_is_taken_wherever_it_stands() {
        let card = device("card", vk::PhysicalDeviceType::DISCRETE_GPU, Driver::Gpu, false);
        let other = device("other", vk::PhysicalDeviceType::CPU, Driver::OtherCpu, false);
        let of_software = [swift_shader(), other.clone(), lavapipe()];
        for turn in 0..3 {
            let mut all = of_software.clone();
            all.rotate_left(turn);
            assert_eq!(chosen(&all, &DeviceChoice::Best), "llvmpipe");
            assert_eq!(chosen(&all, &DeviceChoice::Cpu), "llvmpipe");
            let mut all = all.to_vec();
            all.insert(turn, card.clone());
            assert_eq!(chosen(&all, &DeviceChoice::Best), "card");
            assert_eq!(chosen(&all, &DeviceChoice::Cpu), "llvmpipe");
        }
        assert_eq!(chosen(&[other, swift_shader()], &DeviceChoice::Cpu), "SwiftShader");
        assert_eq!(chosen(&[swift_shader(), lavapipe()], &DeviceChoice::Index(0)), "SwiftShader");
        assert_eq!(chosen(&[swift_shader(), lavapipe()], &DeviceChoice::Name("swift".into())), "SwiftShader");
    }

    #[test]
    fn why_one_comes_first_is_said() {
        assert_eq!(advantage(&lavapipe(), &swift_shader()), "computes in f64");
        let card = device("card", vk::PhysicalDeviceType::DISCRETE_GPU, Driver::Gpu, true);
        assert_eq!(advantage(&card, &lavapipe()), "is a discrete GPU, this a software device");
        let long = Candidate { subgroup_size: 8, ..lavapipe() };
        assert_eq!(advantage(&lavapipe(), &long), "comes first in the loader's list");
        let mut newer = lavapipe();
        newer.properties.api_version += 1;
        assert_eq!(advantage(&newer, &lavapipe()), "has the newer Vulkan");
    }

    #[test]
    fn what_cannot_be_used_comes_last_and_says_why() {
        let broken = Candidate { heap: 0, ..lavapipe() };
        assert_eq!(chosen(&[broken.clone(), swift_shader()], &DeviceChoice::Cpu), "SwiftShader");
        for choice in [DeviceChoice::Best, DeviceChoice::Cpu] {
            let error = choose(std::slice::from_ref(&broken), &choice, &["a.json is no driver".into()]);
            let text = error.map(|c| c.name).expect_err("no device").to_string();
            assert!(text.contains("no memory") && text.contains("a.json is no driver"), "{text}");
        }
    }
}
