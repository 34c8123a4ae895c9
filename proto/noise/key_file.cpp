// See key_file.h.
#include "proto/noise/key_file.h"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "proto/noise/private_file.h"

namespace hapticd::noise {
namespace {

constexpr std::string_view kMark = "hapticd";
constexpr std::size_t kRoleAt = kMark.size();
constexpr std::size_t kPskAt = kRoleAt + 1;
constexpr std::size_t kServerAt = kPskAt + kKeyBytes;
static_assert(kServerAt + kKeyBytes == kKeyFileBytes);

using FileBytes = std::array<std::uint8_t, kKeyFileBytes>;

Locked<FileBytes> bytes_of(const SessionKey& key) {
  return Locked<FileBytes>::filled([&](FileBytes& bytes) {
    std::copy(kMark.begin(), kMark.end(), bytes.begin());
    bytes[kRoleAt] = static_cast<std::uint8_t>(key.role);
    std::copy_n(key.psk.get().begin(), kKeyBytes, bytes.begin() + kPskAt);
    std::copy_n(key.server.begin(), kKeyBytes, bytes.begin() + kServerAt);
  });
}

Key key_at(const FileBytes& bytes, std::size_t offset) {
  Key key;
  std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(offset), kKeyBytes, key.begin());
  return key;
}

bool is_session_key(const FileBytes& bytes, std::size_t size) {
  return size == kKeyFileBytes && std::equal(kMark.begin(), kMark.end(), bytes.begin()) &&
         (bytes[kRoleAt] == static_cast<std::uint8_t>(Role::kView) ||
          bytes[kRoleAt] == static_cast<std::uint8_t>(Role::kControl));
}

}  // namespace

SessionKey read_session_key(const std::filesystem::path& file) {
  std::size_t size = 0;
  const auto bytes =
      Locked<FileBytes>::filled([&](FileBytes& into) { size = read_private_file(file, into); });
  if (size == kBareKeyBytes) {
    refuse_file(file,
                "a key of an earlier version, by which nobody can tell the daemon from another "
                "that has the key. Run 'hapticctl keygen DIR' on the folder of hapticd --keys, "
                "which keeps its keys, and copy the file from there again.");
  }
  if (!is_session_key(bytes.get(), size)) {
    refuse_file(file,
                "not a key: view.key, control.key and those of clients have 72 bytes. Make keys "
                "with 'hapticctl keygen DIR'.");
  }
  return {static_cast<Role>(bytes.get()[kRoleAt]), SecretKey::filled([&](Key& psk) {
            std::copy_n(bytes.get().begin() + kPskAt, kKeyBytes, psk.begin());
          }),
          key_at(bytes.get(), kServerAt)};
}

void write_session_key(const std::filesystem::path& file, const SessionKey& key) {
  write_private_file(file, bytes_of(key).get());
}

void replace_session_key(const std::filesystem::path& file, const SessionKey& key) {
  replace_private_file(file, bytes_of(key).get());
}

SecretKey read_bare_key(const std::filesystem::path& file) {
  std::size_t size = 0;
  SecretKey key = SecretKey::filled([&](Key& into) { size = read_private_file(file, into); });
  if (size != kBareKeyBytes) {
    refuse_file(file,
                "not a key: stop.key and server.key have 32 bytes. Make keys with 'hapticctl "
                "keygen DIR'.");
  }
  return key;
}

void write_bare_key(const std::filesystem::path& file, const SecretKey& key) {
  write_private_file(file, key.get());
}

SecretKey random_key() {
  return SecretKey::filled([](Key& key) { randombytes_buf(key.data(), key.size()); });
}

}  // namespace hapticd::noise
