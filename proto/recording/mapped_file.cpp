// See mapped_file.h.
#include "proto/recording/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace hapticd {
namespace {

std::string reason() { return std::generic_category().message(errno); }

}  // namespace

MappedFile::~MappedFile() {
  if (data_ != nullptr) ::munmap(const_cast<char*>(data_), size_);
}

bool MappedFile::open(const std::string& path, std::string& error) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) {
    error = path + ": " + reason();
    return false;
  }
  struct stat status {};
  bool good = ::fstat(file, &status) == 0;
  if (good && S_ISDIR(status.st_mode)) {
    error = path + " is a folder";
    ::close(file);
    return false;
  }
  if (good && status.st_size > 0) {
    const auto size = static_cast<std::size_t>(status.st_size);
    void* const data = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file, 0);
    good = data != MAP_FAILED;
    if (good) {
      data_ = static_cast<const char*>(data);
      size_ = size;
    }
  }
  if (!good) error = path + ": " + reason();
  ::close(file);
  return good;
}

}  // namespace hapticd
