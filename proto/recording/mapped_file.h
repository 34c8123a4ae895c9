// A whole file as bytes in memory, read-only, mapped on demand. Not RT.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace hapticd {

class MappedFile {
 public:
  MappedFile() = default;
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  /// Maps `path`; false with `error` (for people) when it cannot be read. Call once.
  bool open(const std::string& path, std::string& error);

  /// Valid while this lives. A file that someone shortens meanwhile ends the process with SIGBUS:
  /// recordings are only ever appended to.
  [[nodiscard]] std::string_view bytes() const noexcept { return {data_, size_}; }

 private:
  const char* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace hapticd
