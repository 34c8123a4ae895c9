// What is fuzzed of scenes: any bytes as the text of a scene. Not RT.
#pragma once

#include <cstdint>
#include <span>

namespace hapticd::test {

/// Loads `bytes` as an inline scene, without folders of models. A scene that is taken is played a
/// few ticks and must give finite forces within the limits; one that is refused must say why.
/// Aborts where that does not hold. True when it was taken.
bool check_scene_bytes(std::span<const std::uint8_t> bytes);

}  // namespace hapticd::test
