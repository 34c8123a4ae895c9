// See key_file.h.
#include "proto/noise/key_file.h"

#include <fcntl.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <string>
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

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& what) {
  throw std::runtime_error(file.string() + ": " + what);
}

std::string reason() { return std::generic_category().message(errno); }

void write_key(const std::filesystem::path& file) {
  Key key;
  randombytes_buf(key.data(), key.size());
  const Descriptor made(::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kOwnerOnly));
  if (made.get() < 0) refuse(file, reason() + ". Give a folder you may write to.");
  const bool written =
      ::fchmod(made.get(), kOwnerOnly) == 0 &&
      ::write(made.get(), key.data(), key.size()) == static_cast<ssize_t>(key.size()) &&
      ::fsync(made.get()) == 0;
  sodium_memzero(key.data(), key.size());
  if (!written) refuse(file, reason() + ". Remove it and try again.");
}

}  // namespace

Key read_key_file(const std::filesystem::path& file) {
  const Descriptor opened(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (opened.get() < 0) {
    refuse(file, reason() + ". Make keys with 'hapticctl keygen DIR', or copy them from there.");
  }
  struct stat status {};
  if (::fstat(opened.get(), &status) != 0) refuse(file, reason());
  if (!S_ISREG(status.st_mode) || status.st_size != static_cast<off_t>(kKeyBytes)) {
    refuse(file, "not a key: a key is a file of 32 bytes. Make keys with 'hapticctl keygen DIR'.");
  }
  if ((status.st_mode & kOthers) != 0) {
    refuse(file, "others may access it. Run 'chmod 600 " + file.string() +
                     "', and make new keys if they may have read it.");
  }
  Key key;
  if (::read(opened.get(), key.data(), key.size()) != static_cast<ssize_t>(key.size())) {
    refuse(file, reason());
  }
  return key;
}

KeyPair read_key_folder(const std::filesystem::path& folder) {
  const KeyPair keys{read_key_file(folder / kViewKeyName), read_key_file(folder / kControlKeyName)};
  if (keys.view == keys.control) {
    refuse(folder,
           "view.key and control.key are equal, so that who may look could control. Make "
           "keys with 'hapticctl keygen DIR'.");
  }
  return keys;
}

void make_key_folder(const std::filesystem::path& named) {
  if (sodium_init() < 0) throw std::runtime_error("libsodium does not start");
  std::error_code error;
  // keys/ is keys: what follows the last slash is not a separate folder.
  const std::filesystem::path folder = named.has_filename() ? named : named.parent_path();
  if (!std::filesystem::is_directory(folder, error)) {
    if (folder.has_parent_path()) std::filesystem::create_directories(folder.parent_path(), error);
    if (::mkdir(folder.c_str(), 0700) != 0) refuse(folder, reason() + ". Give another folder.");
  }
  const auto is_there = [&](const char* name) {
    return std::filesystem::exists(std::filesystem::symlink_status(folder / name, error));
  };
  if (is_there(kViewKeyName) && is_there(kControlKeyName) && !is_there(kStopKeyName)) {
    write_key(folder / kStopKeyName);
    return;
  }
  for (const char* name : {kViewKeyName, kControlKeyName, kStopKeyName}) {
    if (is_there(name)) {
      refuse(folder / name,
             "exists already, and clients may have it. Remove all keys first, or give another "
             "folder.");
    }
  }
  for (const char* name : {kViewKeyName, kControlKeyName, kStopKeyName}) write_key(folder / name);
}

}  // namespace hapticd::noise
