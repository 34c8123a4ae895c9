// A folder of its own for a test, removed at its end. Not RT.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace hapticd::test {

class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  /// Path of a file in it.
  [[nodiscard]] std::string path(const std::string& name) const { return path_ + "/" + name; }
  /// Writes a file and returns its path.
  [[nodiscard]] std::string write(const std::string& name, const std::string& content) const;

 private:
  std::string path_;
};

/// The whole file; "" when there is none.
[[nodiscard]] std::string read_text(const std::string& path);

/// Bytes of numbers, little-endian, as a string.
class BinaryText {
 public:
  BinaryText& raw(const std::string& text);
  BinaryText& f32(float value);
  BinaryText& u32(std::uint32_t value);
  BinaryText& u16(std::uint16_t value);
  BinaryText& u8(std::uint8_t value);
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace hapticd::test
