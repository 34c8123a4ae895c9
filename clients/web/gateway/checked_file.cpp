// See checked_file.h.
#include "clients/web/gateway/checked_file.h"

#include <fcntl.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace hapticd::web {
namespace {

using Hash = std::array<unsigned char, 32>;

const unsigned char* bytes_of(std::string_view text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

std::string hexadecimal(const Hash& hash) {
  std::string text(2 * hash.size() + 1, '\0');
  sodium_bin2hex(text.data(), text.size(), hash.data(), hash.size());
  text.pop_back();
  return text;
}

std::array<std::uint8_t, 16> hash_of_block(std::string_view block) {
  std::array<std::uint8_t, 16> hash{};
  crypto_generichash_blake2b(hash.data(), hash.size(), bytes_of(block), block.size(), nullptr, 0);
  return hash;
}

std::int64_t nanoseconds(const timespec& time) {
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

}  // namespace

std::string hash_of(std::string_view bytes) {
  Hash hash{};
  crypto_generichash_blake2b(hash.data(), hash.size(), bytes_of(bytes), bytes.size(), nullptr, 0);
  return hexadecimal(hash);
}

std::optional<OpenFile> OpenFile::at(const std::filesystem::path& path) {
  // A FIFO would wait for whoever writes into it.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (descriptor < 0) return std::nullopt;
  struct stat found {};
  const bool known = ::fstat(descriptor, &found) == 0;
  const FileStamp stamp{found.st_dev, found.st_ino, static_cast<std::uint64_t>(found.st_size),
                        nanoseconds(found.st_mtim), nanoseconds(found.st_ctim)};
  OpenFile file(descriptor, stamp);
  if (!known || !S_ISREG(found.st_mode) || stamp.size > kMaxFileBytes) return std::nullopt;
  return file;
}

OpenFile::OpenFile(OpenFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), stamp_(other.stamp_) {}

OpenFile::~OpenFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::string OpenFile::read(std::uint64_t offset) const {
  std::string block(kBlockBytes, '\0');
  std::size_t taken = 0;
  while (taken < block.size()) {
    const ssize_t more = ::pread(descriptor_, block.data() + taken, block.size() - taken,
                                 static_cast<off_t>(offset + taken));
    if (more < 0 && errno == EINTR) continue;
    if (more <= 0) break;
    taken += static_cast<std::size_t>(more);
  }
  block.resize(taken);
  return block;
}

std::optional<FileDigest> OpenFile::digest() const {
  FileDigest made;
  crypto_generichash_blake2b_state state;
  crypto_generichash_blake2b_init(&state, nullptr, 0, std::tuple_size_v<Hash>);
  while (made.size <= kMaxFileBytes) {
    const std::string block = read(made.size);
    if (!block.empty()) {
      made.blocks.push_back(hash_of_block(block));
      made.size += block.size();
      crypto_generichash_blake2b_update(&state, bytes_of(block), block.size());
    }
    if (block.size() == kBlockBytes) continue;
    Hash hash{};
    crypto_generichash_blake2b_final(&state, hash.data(), hash.size());
    made.hash = hexadecimal(hash);
    return made;
  }
  return std::nullopt;
}

std::optional<std::string> CheckedFile::block(std::size_t index) const {
  std::string bytes = file_.read(std::uint64_t{index} * kBlockBytes);
  if (hash_of_block(bytes) != digest_->blocks[index]) return std::nullopt;
  return bytes;
}

}  // namespace hapticd::web
