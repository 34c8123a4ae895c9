// Meshes and sphere-trees by what is in them: a scene names its files with their BLAKE2b-256, and
// the files of some folders are found by it, so that a page never gets another one than the daemon
// plays. Not RT.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "clients/web/gateway/checked_file.h"

namespace hapticd::web {

class AssetStore {
 public:
  /// Of `folders` and what is below them; links to elsewhere are not followed. Nothing is read yet.
  explicit AssetStore(std::vector<std::filesystem::path> folders);

  /// The file of this hash, 64 lower-case hexadecimal digits; null: there is none. One that has
  /// changed since it was looked at is not served. Folders are looked through at first, and again
  /// for a hash that is not known, each second at most. `now_ns` is of a clock that never goes
  /// back.
  [[nodiscard]] std::shared_ptr<const CheckedFile> find(const std::string& hash,
                                                        std::int64_t now_ns);
  /// Looks through the folders and reads what is new or has changed.
  void look();

 private:
  struct Seen {
    FileStamp stamp;
    std::shared_ptr<const FileDigest> digest;
  };

  void read(const std::filesystem::path& path);

  std::vector<std::filesystem::path> folders_;
  std::map<std::string, std::filesystem::path> files_;  ///< by hash
  std::map<std::filesystem::path, Seen> seen_;
  bool looked_ = false;
  std::int64_t looked_ns_ = 0;
};

}  // namespace hapticd::web
