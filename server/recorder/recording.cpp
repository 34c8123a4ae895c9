// See recording.h.
#include "server/recorder/recording.h"

#include <google/protobuf/stubs/common.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>

#include "core/rt/monotonic_clock.h"
#include "server/haptic_loop/thread_policy.h"
#include "server/recorder/state_record.h"

namespace hapticd {
namespace {

namespace fs = std::filesystem;

/// Time between two rounds. Longer: more of a killed daemon's last ticks are lost (100 ms may be).
constexpr std::chrono::milliseconds kRound{20};

/// Time between two looks for room in a full ring.
constexpr std::chrono::microseconds kWaitForRoom{200};

/// From the monotonic clock to the time of day, ns.
std::int64_t time_of_day_offset_ns() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count() - monotonic_now_ns();
}

RecorderOptions recorder_options() {
  RecorderOptions options;
  options.time_offset_ns = time_of_day_offset_ns();
  return options;
}

/// A folder in the environment; none when it is not set.
std::optional<fs::path> variable(const char* name) {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing in this program changes the environment
  const char* const value = std::getenv(name);
  if (value == nullptr || *value == '\0') return std::nullopt;
  return fs::path(value);
}

}  // namespace

fs::path recordings_folder() {
  if (const auto state = variable("STATE_DIRECTORY")) return *state / "recordings";
  if (const auto xdg = variable("XDG_STATE_HOME")) return *xdg / "hapticd" / "recordings";
  return variable("HOME").value_or("/tmp") / ".local/state/hapticd/recordings";
}

std::vector<std::string> list_recordings(const fs::path& folder) {
  std::vector<std::pair<fs::file_time_type, std::string>> found;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    std::string name = entry.path().filename().string();
    // What is no text cannot be told.
    if (entry.path().extension() != ".mcap" ||
        !google::protobuf::internal::IsStructurallyValidUTF8(name)) {
      continue;
    }
    found.emplace_back(entry.last_write_time(error), std::move(name));
  }
  std::sort(found.begin(), found.end());
  std::vector<std::string> names;
  names.reserve(found.size());
  for (auto& recording : found) names.push_back(std::move(recording.second));
  return names;
}

Recording::Recording(LoopChannels& channels, const v1::RecordHeader& header)
    : traces_(channels.traces), images_(channels.images), recorder_(recorder_options()) {
  recorder_.begin(header);
  thread_ = std::thread([this] { run(); });
}

Recording::~Recording() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_one();
  thread_.join();
  recorder_.stop();
}

void Recording::post(Task task) {
  {
    const std::lock_guard lock(mutex_);
    tasks_.push_back(std::move(task));
  }
}

void Recording::announce(v1::SceneRecord record) {
  const std::lock_guard lock(mutex_);
  scenes_[record.scene_id()] = std::move(record);
}

void Recording::announce_change(v1::ParameterRecord record) {
  const std::lock_guard lock(mutex_);
  changes_[record.number()] = std::move(record);
}

void Recording::forget_change(std::uint64_t number) {
  const std::lock_guard lock(mutex_);
  changes_.erase(number);
}

void Recording::event(std::int64_t t_ns, v1::EventRecord record) {
  post([this, t_ns, record = std::move(record)] {
    recorder_.event(static_cast<std::uint64_t>(t_ns), record);
  });
}

std::future<std::string> Recording::start(fs::path path) {
  auto error = std::make_shared<std::promise<std::string>>();
  std::future<std::string> told = error->get_future();
  post([this, path = std::move(path), error = std::move(error)] {
    error->set_value(recorder_.start(path.string()) ? "" : recorder_.status().error);
  });
  wake_.notify_one();
  return told;
}

void Recording::stop() {
  post([this] {
    take_traces();
    recorder_.stop();
  });
  wake_.notify_one();
}

void Recording::dump(fs::path path) {
  post([this, path = std::move(path)] {
    take_traces();
    DumpResult result{path.string(), ""};
    recorder_.dump(path.string(), result.error);
    const std::lock_guard lock(mutex_);
    dumps_.push_back(std::move(result));
  });
  wake_.notify_one();
}

RecordStatus Recording::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

std::vector<DumpResult> Recording::take_dumps() {
  const std::lock_guard lock(mutex_);
  return std::exchange(dumps_, {});
}

void Recording::make_room() {
  while (traces_.size() > TraceRing::capacity() / 2) {
    wake_.notify_one();
    std::this_thread::sleep_for(kWaitForRoom);
  }
}

// An image stands right behind the tick it was made after; that of a tick that was lost stands
// before the next one.
void Recording::take_images(const TickTrace& trace, bool after) {
  while (const StateImage* image = images_.front()) {
    const bool passed = image->scene_id < trace.scene_id ||
                        (image->scene_id == trace.scene_id && image->next_tick <= trace.tick);
    const bool fits = image->scene_id == trace.scene_id && image->next_tick == trace.tick + 1;
    if (!passed && !(after && fits)) return;
    v1::Snapshot record;
    to_record(*image, record);
    images_.release();
    for (const auto& [path, assignment] : parameters_) *record.add_parameters() = assignment;
    recorder_.snapshot(trace.t_ns, record);
  }
}

void Recording::take_change(const TickTrace& trace) {
  v1::ParameterRecord record;
  {
    const std::lock_guard lock(mutex_);
    auto announced = changes_.extract(trace.change);
    if (announced.empty()) return;
    record = std::move(announced.mapped());
  }
  record.set_tick(trace.tick);
  for (const v1::Assignment& assignment : record.assignments()) {
    parameters_[assignment.path()] = assignment;
  }
  recorder_.parameters(trace.t_ns, record);
}

void Recording::take_trace(const TickTrace& trace) {
  take_images(trace, false);
  if (trace.scene_id != scene_id_) {
    scene_id_ = trace.scene_id;
    parameters_.clear();
    const std::lock_guard lock(mutex_);
    const auto announced = scenes_.find(scene_id_);
    if (announced != scenes_.end()) {
      recorder_.scene(trace.t_ns, announced->second);
      scenes_.erase(scenes_.begin(), std::next(announced));
    }
  }
  if (trace.change != 0) take_change(trace);
  recorder_.tick(trace);
  take_images(trace, true);
}

void Recording::take_traces() {
  while (const TickTrace* trace = traces_.front()) {
    take_trace(*trace);
    traces_.release();
  }
  const std::uint64_t lost = traces_.overflow();
  if (lost != lost_) recorder_.lost_ticks(lost - lost_);
  lost_ = lost;
}

void Recording::round() {
  std::deque<Task> tasks;
  {
    const std::lock_guard lock(mutex_);
    tasks.swap(tasks_);
  }
  for (const Task& task : tasks) task();
  take_traces();
  recorder_.poll(static_cast<std::uint64_t>(monotonic_now_ns()));
  RecordStatus status = recorder_.status();
  const std::lock_guard lock(mutex_);
  status_ = std::move(status);
}

void Recording::run() {
  name_thread("recorder");
  while (true) {
    round();
    std::unique_lock lock(mutex_);
    if (ending_) break;
    wake_.wait_for(lock, kRound);
  }
  round();
}

}  // namespace hapticd
