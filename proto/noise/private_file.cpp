// See private_file.h.
#include "proto/noise/private_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>
#include <system_error>

namespace hapticd::noise {
namespace {

constexpr mode_t kOwnerOnly = 0600;
constexpr mode_t kOthers = 0077;

/// Closes a file.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const noexcept { return fd_; }

 private:
  int fd_;
};

std::string reason() { return std::generic_category().message(errno); }

}  // namespace

void refuse_file(const std::filesystem::path& file, const std::string& what) {
  throw std::runtime_error(file.string() + ": " + what);
}

std::size_t read_private_file(const std::filesystem::path& file, std::span<std::uint8_t> into) {
  const Descriptor opened(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (opened.get() < 0) {
    refuse_file(file,
                reason() + ". Make keys with 'hapticctl keygen DIR', or copy them from there.");
  }
  struct stat status {};
  if (::fstat(opened.get(), &status) != 0) refuse_file(file, reason());
  if (!S_ISREG(status.st_mode)) {
    refuse_file(file, "not a file, so not a key. Make keys with 'hapticctl keygen DIR'.");
  }
  if ((status.st_mode & kOthers) != 0) {
    refuse_file(file, "others may access it. Run 'chmod 600 " + file.string() +
                          "', and make new keys if they may have read it.");
  }
  const auto size = static_cast<std::size_t>(status.st_size);
  const std::size_t wanted = std::min(size, into.size());
  if (::read(opened.get(), into.data(), wanted) != static_cast<ssize_t>(wanted)) {
    refuse_file(file, reason());
  }
  return size;
}

void write_private_file(const std::filesystem::path& file, std::span<const std::uint8_t> bytes) {
  const Descriptor made(::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kOwnerOnly));
  if (made.get() < 0) refuse_file(file, reason() + ". Give a folder you may write to.");
  const bool written =
      ::fchmod(made.get(), kOwnerOnly) == 0 &&
      ::write(made.get(), bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()) &&
      ::fsync(made.get()) == 0;
  if (!written) refuse_file(file, reason() + ". Remove it and try again.");
}

void replace_private_file(const std::filesystem::path& file, std::span<const std::uint8_t> bytes) {
  std::filesystem::path part = file;
  part += ".part";
  std::error_code error;
  std::filesystem::remove(part, error);
  write_private_file(part, bytes);
  std::filesystem::rename(part, file, error);
  if (error) refuse_file(file, error.message() + ". Give a folder you may write to.");
}

void make_private_folder(const std::filesystem::path& folder) {
  std::error_code error;
  if (std::filesystem::is_directory(folder, error)) return;
  if (folder.has_parent_path()) std::filesystem::create_directories(folder.parent_path(), error);
  if (::mkdir(folder.c_str(), 0700) != 0) refuse_file(folder, reason() + ". Give another folder.");
}

}  // namespace hapticd::noise
