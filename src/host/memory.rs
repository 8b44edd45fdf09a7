//! Memory of the host that this process may still take.

/// Bytes that this process can still have: of the machine (swap included), of each control group that it is in, and of
/// its own limits on address space and data (`ulimit -v`, `ulimit -d`). None where nothing is known.
pub fn free() -> Option<u64> {
    let limits = [machine(), control_groups(), address_space()];
    limits.into_iter().flatten().min()
}

/// Memory that can be had without pushing anything out but caches, and free swap.
fn machine() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    Some(kibibytes(&text, "MemAvailable:")? + kibibytes(&text, "SwapFree:").unwrap_or(0))
}

/// The line `NAME  N kB` of a file of /proc, in bytes.
fn kibibytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.split_whitespace().next()?.parse::<u64>().ok()?.checked_mul(1024)
}

/// What the control groups of this process leave; those above it count as well.
fn control_groups() -> Option<u64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    let mut least = None;
    for line in groups.lines() {
        // hierarchy:controllers:path; version 2 has no list of controllers.
        let mut parts = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (parts.next(), parts.next()) else { continue };
        let (root, files) = match controllers {
            "" => ("/sys/fs/cgroup", ["memory.max", "memory.current", "inactive_file"]),
            c if c.split(',').any(|c| c == "memory") => (
                "/sys/fs/cgroup/memory",
                ["memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"],
            ),
            _ => continue,
        };
        // Inside a container the path may be one that is not seen here: then the root is its own.
        for group in std::path::Path::new(path).ancestors() {
            let folder = std::path::Path::new(root).join(group.strip_prefix("/").unwrap_or(group));
            least = [least, group_free(&folder, files)].into_iter().flatten().min();
        }
    }
    least
}

/// What one control group leaves: its limit less what is used and could not be dropped. None without a limit.
fn group_free(folder: &std::path::Path, [limit, used, cached]: [&str; 3]) -> Option<u64> {
    let number = |name: &str| std::fs::read_to_string(folder.join(name)).ok()?.trim().parse::<u64>().ok();
    let stat = std::fs::read_to_string(folder.join("memory.stat")).unwrap_or_default();
    let cached = stat.lines().find_map(|line| line.strip_prefix(cached)?.trim().parse::<u64>().ok());
    Some(number(limit)?.saturating_sub(number(used)?.saturating_sub(cached.unwrap_or(0))))
}

/// Bytes that this process's own limits on address space and data leave.
#[cfg(unix)]
pub fn address_space() -> Option<u64> {
    use rustix::process::{Resource, getrlimit};
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let left = |limit, used| {
        let limit = getrlimit(limit).current?;
        Some(limit.saturating_sub(kibibytes(&text, used).unwrap_or(0)))
    };
    [left(Resource::As, "VmSize:"), left(Resource::Data, "VmData:")].into_iter().flatten().min()
}

/// Bytes that this process's own limits leave: not known here.
#[cfg(not(unix))]
pub fn address_space() -> Option<u64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_proc_are_read() {
        let text = "MemTotal:  99 kB\nMemAvailable:   22262 kB\nSwapFree: 0 kB\n";
        assert_eq!(kibibytes(text, "MemAvailable:"), Some(22262 * 1024));
        assert_eq!(kibibytes(text, "MemFree:"), None);
    }

    #[test]
    fn a_group_leaves_what_it_does_not_use() {
        let folder = tempfile::tempdir().unwrap();
        let files = ["memory.max", "memory.current", "inactive_file"];
        let put = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        assert_eq!(group_free(folder.path(), files), None);
        put("memory.max", "1000\n");
        put("memory.current", "700\n");
        assert_eq!(group_free(folder.path(), files), Some(300));
        put("memory.stat", "anon 600\ninactive_file 100\n");
        assert_eq!(group_free(folder.path(), files), Some(400));
        put("memory.max", "max\n");
        assert_eq!(group_free(folder.path(), files), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn something_is_free() {
        assert!(free().unwrap() > 1 << 20);
    }
}
