//! Names of the processor and of the build, for tables of measured times.

/// Model name of the processor, as the system reports it.
#[must_use]
pub fn processor() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = info.lines().find_map(|l| l.strip_prefix("model name")?.split_once(':').map(|(_, n)| n.trim().to_string()));
    name.unwrap_or_else(|| format!("{} {}", std::env::consts::OS, std::env::consts::ARCH))
}

/// Number of processors available to this process.
#[must_use]
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

/// Cargo profile with which this program was built. Published times were measured with `measure`.
pub const PROFILE: &str = env!("PALPATE_PROFILE");

/// Version, profile and vector instructions of this program.
#[must_use]
pub fn build() -> String {
    let vectors = if cfg!(target_feature = "avx2") { "AVX2" } else { "baseline" };
    format!("palpate {} {PROFILE}, {} {vectors}", env!("CARGO_PKG_VERSION"), std::env::consts::ARCH)
}
