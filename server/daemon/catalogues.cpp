// See catalogues.h.
#include "server/daemon/catalogues.h"

#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "proto/wire/whole_characters.h"
#include "server/recorder/recorder_thread.h"
#include "server/scene_io/gesture_loader.h"
#include "server/scene_io/message_text.h"
#include "server/scene_io/model_files.h"
#include "server/scene_io/named_text.h"

namespace hapticd {
namespace {

namespace fs = std::filesystem;

/// A file that was changed so short a time before it was read may be changed again without a new
/// time, since the system's times are coarse, ns: it is not taken to be known.
constexpr std::int64_t kSettled_ns = 1'000'000'000;
/// The order of recordings is looked at so often, ns.
constexpr std::int64_t kOrderPeriod_ns = 1'000'000'000;

std::int64_t nanoseconds(const timespec& time) {
  return std::int64_t{1'000'000'000} * time.tv_sec + time.tv_nsec;
}

/// Zeros where there is nothing.
FileIdentity identity_of(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return {};
  return {status.st_dev, status.st_ino, static_cast<std::uint64_t>(status.st_size),
          nanoseconds(status.st_mtim), nanoseconds(status.st_ctim)};
}

/// The first of `names`, or the last ones, as many as a list has.
std::vector<ListedName> plain(const std::vector<std::string>& names, bool last = false) {
  const std::size_t count = std::min(names.size(), kMaxListed);
  const std::size_t begin = last ? names.size() - count : 0;
  std::vector<ListedName> listed;
  listed.reserve(count);
  for (std::size_t k = begin; k < begin + count; ++k) listed.push_back({names[k], ""});
  return listed;
}

std::string description_of_gesture(const fs::path& path) {
  const GestureResult loaded = load_gesture(path.string(), {});
  return loaded.gesture ? loaded.gesture->description() : "";
}

/// Of the text alone: no model is read.
std::string description_of_scene(const fs::path& path) {
  v1::Scene scene;
  const NamedText named = read_named(path.string(), {}, "scene", kMaxText);
  const MessageText parsed(named.text, path.string(), "scene", scene);
  return any_fault(parsed.problems()) ? "" : scene.description();
}

std::int64_t wall_clock_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace

CatalogueSources installed_catalogues() {
  return {installed_paths().scenes, installed_gestures(),   recordings_folder(),
          description_of_scene,     description_of_gesture, wall_clock_ns};
}

Catalogues::Catalogues(CatalogueSources sources) : sources_(std::move(sources)) {}

bool Catalogues::is_settled(const FileIdentity& file) const {
  const std::int64_t age_ns = sources_.now_ns() - file.changed_ns;
  return age_ns >= kSettled_ns || age_ns <= -kSettled_ns;
}

bool Catalogues::is_stale(Kept& kept, const std::vector<fs::path>& folders) const {
  std::vector<FileIdentity> now;
  now.reserve(folders.size());
  for (const fs::path& folder : folders) now.push_back(identity_of(folder));
  if (kept.read && now == kept.folders) return false;
  kept.read = true;
  for (const FileIdentity& folder : now) kept.read = kept.read && is_settled(folder);
  kept.folders = std::move(now);
  kept.read_ns = sources_.now_ns();
  return true;
}

const std::vector<ListedName>& Catalogues::scenes() {
  if (is_stale(scenes_, sources_.scenes)) scenes_.names = plain(list_names(sources_.scenes));
  describe(scenes_, sources_.scenes, sources_.describe_scene);
  return scenes_.names;
}

const std::vector<ListedName>& Catalogues::recordings() {
  const std::int64_t age_ns = sources_.now_ns() - recordings_.read_ns;
  if (age_ns < 0 || age_ns >= kOrderPeriod_ns) recordings_.read = false;
  if (is_stale(recordings_, {sources_.recordings})) {
    recordings_.names = plain(list_recordings(sources_.recordings), true);
  }
  return recordings_.names;
}

const std::vector<ListedName>& Catalogues::gestures() {
  if (is_stale(gestures_, sources_.gestures)) {
    gestures_.names = plain(list_names(sources_.gestures));
  }
  describe(gestures_, sources_.gestures, sources_.describe_gesture);
  return gestures_.names;
}

void Catalogues::describe(Kept& kept, const std::vector<fs::path>& folders,
                          const std::function<std::string(const fs::path&)>& read) {
  std::map<fs::path, Described> described;
  for (ListedName& each : kept.names) {
    const fs::path path = installed_file(each.name, folders);
    const FileIdentity file = identity_of(path);
    const auto known = kept.described.find(path);
    if (known != kept.described.end() && known->second.settled && known->second.file == file) {
      described.insert(kept.described.extract(known));
    } else {
      described[path] = {file, is_settled(file), path.empty() ? std::string() : read(path)};
    }
    const std::string& text = described[path].description;
    each.description = wire::whole_characters(text.substr(0, text.find('\n')), wire::kMessageBytes);
  }
  kept.described = std::move(described);
}

}  // namespace hapticd
