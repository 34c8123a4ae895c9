// See record_file.h.
#include "device/attach/record_file.h"

#include <fcntl.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <stdexcept>
#include <system_error>

namespace hapticd {
namespace {

namespace fs = std::filesystem;

/// More than any record has, bytes.
constexpr std::size_t kMaxRecord = 4096;

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

[[noreturn]] void refuse(const fs::path& file, const std::string& why) {
  throw std::runtime_error(file.string() + ": " + why +
                           ". Give hapticd a folder it may write to, then check again.");
}

/// Makes the name of a file last.
bool keep_entries(const fs::path& folder) {
  const Descriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return opened.get() >= 0 && ::fsync(opened.get()) == 0;
}

}  // namespace

std::string hex(std::span<const std::uint8_t> bytes) {
  std::string text(2 * bytes.size() + 1, '\0');
  sodium_bin2hex(text.data(), text.size(), bytes.data(), bytes.size());
  text.pop_back();
  return text;
}

std::string plain(std::string_view text) {
  std::string out(text);
  std::replace_if(
      out.begin(), out.end(),
      [](char c) {
        const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
        return !letter && !(c >= '0' && c <= '9') && c != '-' && c != ' ';
      },
      '_');
  return out;
}

std::string seal_of(std::string_view text) {
  std::array<std::uint8_t, crypto_generichash_BYTES_MIN> hash{};
  if (sodium_init() < 0 || crypto_generichash(hash.data(), hash.size(),
                                              reinterpret_cast<const unsigned char*>(text.data()),
                                              text.size(), nullptr, 0) != 0) {
    throw std::runtime_error("the hash of libsodium does not work on this machine");
  }
  return "seal: \"" + hex(hash) + "\"\n";
}

bool is_there(const fs::path& file) {
  std::error_code error;
  return fs::exists(fs::symlink_status(file, error));
}

std::string read_record(const fs::path& file, std::string& text) {
  const Descriptor opened(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (opened.get() < 0) return reason();
  std::array<char, kMaxRecord> bytes{};
  const ssize_t size = ::read(opened.get(), bytes.data(), bytes.size());
  if (size < 0) return reason();
  text.assign(bytes.data(), static_cast<std::size_t>(size));
  return "";
}

void write_record(const fs::path& file, const std::string& text) {
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  const fs::path fresh = file.string() + ".new";
  {
    const Descriptor made(::open(fresh.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
    if (made.get() < 0) refuse(fresh, reason());
    if (::write(made.get(), text.data(), text.size()) != static_cast<ssize_t>(text.size()) ||
        ::fsync(made.get()) != 0) {
      const std::string why = reason();
      fs::remove(fresh, error);
      refuse(fresh, why);
    }
  }
  fs::rename(fresh, file, error);
  if (error) refuse(file, error.message());
  if (!keep_entries(file.parent_path())) refuse(file.parent_path(), reason());
}

void remove_record(const fs::path& file) {
  std::error_code error;
  const bool removed = fs::remove(file, error);
  if (error) throw std::runtime_error(file.string() + ": " + error.message() + ". Remove it.");
  if (removed && !keep_entries(file.parent_path())) refuse(file.parent_path(), reason());
}

}  // namespace hapticd
