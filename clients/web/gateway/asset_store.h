// Meshes and sphere-trees by what is in them: a scene names its files with their BLAKE2b-256, and
// the files of some folders are found by it, so that a page never gets another one than the daemon
// plays. Not RT.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hapticd::web {

/// Longest file that is served, bytes.
inline constexpr std::uintmax_t kMaxAssetBytes = 64U << 20U;

/// BLAKE2b-256 of `bytes` in hexadecimal, as in an address of the gateway.
[[nodiscard]] std::string hash_of(std::string_view bytes);

class AssetStore {
 public:
  /// Looks through `folders` and what is below them; links to elsewhere are not followed.
  explicit AssetStore(std::vector<std::filesystem::path> folders);

  /// The file of this hash, 64 lower-case hexadecimal digits. One that has changed since it was
  /// looked at is not served. Folders are looked through again for a hash that is not known, each
  /// second at most.
  [[nodiscard]] std::optional<std::string> find(const std::string& hash, std::int64_t now_ns);
  /// Files known.
  [[nodiscard]] std::size_t size() const noexcept { return files_.size(); }

 private:
  void look();

  std::vector<std::filesystem::path> folders_;
  std::map<std::string, std::filesystem::path> files_;  ///< by hash
  /// What was hashed already, by path: time of its last change.
  std::map<std::filesystem::path, std::filesystem::file_time_type> seen_;
  std::int64_t looked_ns_ = 0;
};

/// The bytes of `file`; nothing when it cannot be read or is longer than kMaxAssetBytes.
[[nodiscard]] std::optional<std::string> read_whole(const std::filesystem::path& file);

}  // namespace hapticd::web
