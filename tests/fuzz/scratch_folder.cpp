// See scratch_folder.h.
#include "tests/fuzz/scratch_folder.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <system_error>

namespace hapticd::test {

namespace fs = std::filesystem;

ScratchFolder::ScratchFolder()
    : folder_((fs::temp_directory_path() / "hapticd_fuzz_XXXXXX").string()) {
  if (mkdtemp(folder_.data()) == nullptr) throw std::runtime_error("no folder to write to");
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

std::string ScratchFolder::write(const std::string& name,
                                 std::span<const std::uint8_t> bytes) const {
  const fs::path whole = path(name);
  std::error_code ignored;
  fs::create_directories(whole.parent_path(), ignored);
  std::ofstream file(whole, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) throw std::runtime_error("cannot write " + whole.string());
  return whole.string();
}

void ScratchFolder::remove(const std::string& name) const {
  std::error_code ignored;
  fs::remove_all(path(name), ignored);
}

}  // namespace hapticd::test
