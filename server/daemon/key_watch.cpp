// See key_watch.h.
#include "server/daemon/key_watch.h"

#include <sys/stat.h>

#include <algorithm>
#include <system_error>
#include <utility>

namespace hapticd {
namespace {

/// Time between two looks, ns.
constexpr std::int64_t kPeriod_ns = 500'000'000;
/// Files that are looked at.
constexpr std::size_t kMaxFiles = 4 * noise::kMaxClientKeys;

std::int64_t ns_of(const timespec& time) { return 1'000'000'000 * time.tv_sec + time.tv_nsec; }

}  // namespace

KeyWatch::KeyWatch(std::filesystem::path folder)
    : folder_(std::move(folder)), own_(noise::read_key_folder(folder_)), seen_(look()) {
  read();
}

std::vector<KeyWatch::Seen> KeyWatch::look() const {
  std::vector<Seen> seen;
  std::error_code error;
  std::filesystem::directory_iterator each(folder_ / noise::kClientFolderName, error);
  for (; !error && each != std::filesystem::directory_iterator() && seen.size() < kMaxFiles;
       each.increment(error)) {
    struct stat status {};
    Seen file{each->path().filename().string(), {}};
    if (::stat(each->path().c_str(), &status) == 0) {
      file.facts = {static_cast<std::int64_t>(status.st_ino), ns_of(status.st_ctim),
                    ns_of(status.st_mtim), static_cast<std::int64_t>(status.st_size),
                    static_cast<std::int64_t>(status.st_mode)};
    }
    seen.push_back(std::move(file));
  }
  std::sort(seen.begin(), seen.end(), [](const Seen& a, const Seen& b) { return a.name < b.name; });
  return seen;
}

void KeyWatch::read() {
  noise::ClientKeys clients = noise::read_client_keys(folder_, own_);
  keys_ = own_;
  keys_.known.insert(keys_.known.end(), clients.known.begin(), clients.known.end());
  problems_ = std::move(clients.problems);
}

bool KeyWatch::follow(std::int64_t now_ns) {
  if (now_ns < due_ns_) return false;
  due_ns_ = now_ns + kPeriod_ns;
  // Looked at before it is read: what changes in between is seen the next time.
  std::vector<Seen> seen = look();
  if (seen == seen_) return false;
  read();
  seen_ = std::move(seen);
  return true;
}

}  // namespace hapticd
