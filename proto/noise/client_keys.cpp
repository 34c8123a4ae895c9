// See client_keys.h.
#include "proto/noise/client_keys.h"

#include <algorithm>
#include <stdexcept>
#include <system_error>

#include "proto/noise/private_file.h"

namespace hapticd::noise {
namespace {

constexpr const char* kEnding = ".key";
constexpr std::size_t kMaxNameBytes = 64;
/// Names in the folder that are looked at.
constexpr std::size_t kMaxEntries = 1024;

std::filesystem::path clients_of(const std::filesystem::path& folder) {
  return folder / kClientFolderName;
}

/// Names of the files that end in .key, in order.
std::vector<std::string> client_names(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  std::filesystem::directory_iterator each(clients_of(folder), error);
  for (std::size_t seen = 0; !error && each != std::filesystem::directory_iterator();
       each.increment(error)) {
    if (++seen > kMaxEntries) break;
    const std::filesystem::path file = each->path().filename();
    if (file.extension() == kEnding) names.push_back(file.stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

void check_name(const std::string& name) {
  if (is_client_name(name)) return;
  throw std::runtime_error(
      "the name of a client is 1 to 64 small letters, digits, '_' and '-'. Give such a name.");
}

bool is_taken(const SecretKey& psk, const ServerKeys& keys, const std::vector<KnownKey>& known) {
  const auto same = [&](const KnownKey& other) { return other.psk == psk; };
  return std::any_of(keys.known.begin(), keys.known.end(), same) ||
         std::any_of(known.begin(), known.end(), same);
}

KnownKey read_client_key(const std::filesystem::path& file, const std::string& name,
                         const Key& server) {
  const SessionKey key = read_session_key(file);
  if (key.server != server) {
    refuse_file(file, "a key of another daemon. Remove it, and make one with 'hapticctl keygen'.");
  }
  return {name, key.role, key.psk};
}

}  // namespace

bool is_client_name(std::string_view name) noexcept {
  const auto fits = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  return !name.empty() && name.size() <= kMaxNameBytes &&
         std::all_of(name.begin(), name.end(), fits);
}

std::filesystem::path client_key_file(const std::filesystem::path& folder,
                                      const std::string& name) {
  return clients_of(folder) / (name + kEnding);
}

std::filesystem::path make_client_key(const std::filesystem::path& folder, const std::string& name,
                                      Role role) {
  check_name(name);
  const SecretKey own = read_bare_key(folder / kServerKeyName);
  const std::filesystem::path file = client_key_file(folder, name);
  std::error_code unknown;
  if (std::filesystem::exists(std::filesystem::symlink_status(file, unknown))) {
    refuse_file(file, "exists already, and its client may have it. Revoke it first with --revoke.");
  }
  if (client_names(folder).size() >= kMaxClientKeys) {
    refuse_file(clients_of(folder), "has 64 keys, as many as hapticd knows. Revoke one first.");
  }
  make_private_folder(clients_of(folder));
  replace_session_key(file, {role, random_key(), public_half(own.get())});
  return file;
}

void revoke_client_key(const std::filesystem::path& folder, const std::string& name) {
  check_name(name);
  const std::filesystem::path file = client_key_file(folder, name);
  std::error_code error;
  if (std::filesystem::remove(file, error)) return;
  refuse_file(file, error ? error.message() + ". Run it as the owner of the folder."
                          : "there is no such key. Those that are there: --list.");
}

ClientKeys read_client_keys(const std::filesystem::path& folder, const ServerKeys& keys) {
  ClientKeys read;
  for (const std::string& name : client_names(folder)) {
    const std::filesystem::path file = client_key_file(folder, name);
    try {
      if (!is_client_name(name)) {
        refuse_file(file, "not the name of a client: small letters, digits, '_' and '-'.");
      }
      if (read.known.size() >= kMaxClientKeys) refuse_file(file, "one key too many: 64 are known.");
      KnownKey key = read_client_key(file, name, keys.server);
      if (is_taken(key.psk, keys, read.known)) {
        refuse_file(file, "the same key as another. Remove it, and make one of its own.");
      }
      read.known.push_back(std::move(key));
    } catch (const std::runtime_error& error) {
      read.problems.emplace_back(error.what());
    }
  }
  return read;
}

}  // namespace hapticd::noise
