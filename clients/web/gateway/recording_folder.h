// The folder that recordings are shown from: which there are, and where one lies. Names come from
// browsers, so that none leads out of it. Not RT.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "hapticd/v1/answer.pb.h"

namespace hapticd::web {

class RecordingFolder {
 public:
  explicit RecordingFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Names of its recordings, oldest first; none where there is no such folder.
  [[nodiscard]] v1::Listing list() const;
  /// Puts into `file` the one of that name: a plain file of this folder itself. The Result says
  /// what is wrong with the name, or what to do where there is none.
  [[nodiscard]] v1::Result find(std::string_view name, std::filesystem::path& file) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace hapticd::web
