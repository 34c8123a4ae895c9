// What is fuzzed of the configuration: any bytes as the file that --config names. Not RT.
#pragma once

#include <cstdint>
#include <span>

namespace hapticd::test {

/// Reads `bytes` as hapticd reads its configuration at the start and at each SIGHUP. One that is
/// taken has every choice made and every number in its range; one that is refused is refused in
/// plain text, which names the file and a line of it, or the option, and ends as a sentence. Throws
/// std::logic_error where that does not hold. True when it was taken.
bool check_configuration_bytes(std::span<const std::uint8_t> bytes);

}  // namespace hapticd::test
