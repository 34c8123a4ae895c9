// A file of a scene that a peer has brought, in place of one in a folder. Not RT.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/tree/measured_tree.h"

namespace hapticd {

/// Its bytes are in pieces: nobody has to copy what came before when the next one comes.
struct BroughtFile {
  ContentHash hash{};    ///< of all its bytes
  std::size_t size = 0;  ///< bytes
  std::vector<std::string> pieces;

  /// All of it in one. About 0.1 ns per byte.
  [[nodiscard]] std::vector<std::uint8_t> bytes() const {
    std::vector<std::uint8_t> all;
    all.reserve(size);
    for (const std::string& piece : pieces) all.insert(all.end(), piece.begin(), piece.end());
    return all;
  }
};

/// By the names that a scene has for them. They are never looked for in a folder.
using BroughtFiles = std::map<std::string, std::shared_ptr<const BroughtFile>>;

}  // namespace hapticd
