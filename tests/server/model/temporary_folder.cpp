// See temporary_folder.h.
#include "tests/server/model/temporary_folder.h"

#include <bit>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace hapticd::test {

TemporaryFolder::TemporaryFolder()
    : path_((std::filesystem::temp_directory_path() / "hapticd-model-XXXXXX").string()) {
  if (mkdtemp(path_.data()) == nullptr) throw std::runtime_error("no temporary folder");
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string TemporaryFolder::write(const std::string& name, const std::string& content) const {
  std::ofstream(path(name), std::ios::binary) << content;
  return path(name);
}

std::string read_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

BinaryText& BinaryText::raw(const std::string& text) {
  text_ += text;
  return *this;
}
BinaryText& BinaryText::f32(float value) { return u32(std::bit_cast<std::uint32_t>(value)); }
BinaryText& BinaryText::u32(std::uint32_t value) {
  return u16(static_cast<std::uint16_t>(value & 0xffffU))
      .u16(static_cast<std::uint16_t>(value >> 16U));
}
BinaryText& BinaryText::u16(std::uint16_t value) {
  return u8(static_cast<std::uint8_t>(value & 0xffU)).u8(static_cast<std::uint8_t>(value >> 8U));
}
BinaryText& BinaryText::u8(std::uint8_t value) {
  text_ += static_cast<char>(value);
  return *this;
}

}  // namespace hapticd::test
