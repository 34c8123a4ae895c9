// A folder that a fuzz target writes to, for readers that want a path. Not RT.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace hapticd::test {

class ScratchFolder {
 public:
  /// A folder of its own, which goes with this. Throws std::runtime_error where there can be none.
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  [[nodiscard]] std::string path(const std::string& name) const { return folder_ + "/" + name; }
  /// The file `name`, in folders that are made, holds these bytes and nothing else; its path.
  std::string write(const std::string& name, std::span<const std::uint8_t> bytes) const;
  std::string write(const std::string& name, std::string_view text) const {
    return write(name, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  }
  /// Removes the file or the folder `name` with all in it.
  void remove(const std::string& name) const;

 private:
  std::string folder_;
};

}  // namespace hapticd::test
