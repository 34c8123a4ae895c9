// See osc_time.h.
#include "clients/osc/osc_time.h"

namespace hapticd::osc {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
/// Seconds from 1900 to 1970: 70 years, 17 of them leap years.
constexpr std::int64_t kSecondsTo1970 = (70LL * 365 + 17) * 86'400;

}  // namespace

TimeTag tag_of(std::int64_t unix_ns) {
  const std::int64_t seconds = unix_ns / kSecond_ns;
  const auto rest_ns = static_cast<std::uint64_t>(unix_ns % kSecond_ns);
  return {static_cast<std::uint32_t>(seconds + kSecondsTo1970),
          static_cast<std::uint32_t>((rest_ns << 32U) / static_cast<std::uint64_t>(kSecond_ns))};
}

Schedule schedule(std::uint64_t t_ns, std::int64_t delay_ns, const Clocks& clocks) {
  if (delay_ns == 0 || t_ns == 0 || !clocks.daemon_minus_ns.has_value()) return {};
  const std::int64_t own_ns = static_cast<std::int64_t>(t_ns) - *clocks.daemon_minus_ns + delay_ns;
  const std::int64_t ahead_ns = own_ns - clocks.monotonic_ns;
  if (ahead_ns <= 0) return {kImmediately, true};
  return {tag_of(clocks.unix_ns + ahead_ns), false};
}

}  // namespace hapticd::osc
