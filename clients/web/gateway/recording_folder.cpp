// See recording_folder.h.
#include "clients/web/gateway/recording_folder.h"

#include <algorithm>
#include <system_error>
#include <utility>
#include <vector>

#include "proto/wire/request_result.h"
#include "proto/wire/shown_text.h"

namespace hapticd::web {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kEnding = ".mcap";
/// Of Listing.names.
constexpr std::size_t kMaxNames = 4096;

bool is_name(std::string_view name) {
  const bool plain = name.find('/') == name.npos && name.find('\0') == name.npos;
  return plain && !name.starts_with('.') && name.ends_with(kEnding) && name.size() <= 255;
}

/// A file and not a link, which could lead anywhere.
bool is_plain_file(const fs::path& file) {
  std::error_code error;
  return fs::symlink_status(file, error).type() == fs::file_type::regular;
}

}  // namespace

v1::Listing RecordingFolder::list() const {
  std::vector<std::pair<fs::file_time_type, std::string>> found;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_, error)) {
    std::string name = entry.path().filename().string();
    // What is no text cannot be told, and a page could not ask for it.
    if (!is_name(name) || !wire::is_plain(name) || !is_plain_file(entry.path())) continue;
    found.emplace_back(entry.last_write_time(error), std::move(name));
  }
  std::sort(found.begin(), found.end());
  // The newest, where there are more than a listing holds.
  const std::size_t first = found.size() - std::min(found.size(), kMaxNames);
  v1::Listing listing;
  for (std::size_t i = first; i < found.size(); ++i) listing.add_names(std::move(found[i].second));
  return listing;
}

v1::Result RecordingFolder::find(std::string_view name, fs::path& file) const {
  if (!is_name(name)) {
    return wire::result_of(
        v1::RESULT_CODE_INVALID, "show.recording",
        "a recording is a file name that ends in .mcap, without a folder. Choose one of "
        "those listed");
  }
  const fs::path place = folder_ / name;
  if (!is_plain_file(place)) {
    return wire::result_of(v1::RESULT_CODE_NOT_FOUND, "show.recording",
                           std::string(name) + ": no such file in " + folder_.string() +
                               " of haptic-web's machine. Copy it there, or start haptic-web with "
                               "--recordings and its folder");
  }
  file = place;
  return wire::result_of(v1::RESULT_CODE_OK);
}

}  // namespace hapticd::web
