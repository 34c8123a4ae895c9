// See recorder_thread.h.
#include "server/recorder/recorder_thread.h"

#include <google/protobuf/stubs/common.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>

#include "core/rt/memory_boundary.h"
#include "core/rt/monotonic_clock.h"
#include "core/rt/thread_role.h"
#include "proto/recording/default_recordings.h"
#include "server/haptic_loop/thread_policy.h"
#include "server/recorder/state_record.h"
#include "server/scene_io/folder_names.h"

namespace hapticd {
namespace {

namespace fs = std::filesystem;

/// Time between two rounds. Longer: more of a killed daemon's last ticks are lost (100 ms may be).
constexpr std::chrono::milliseconds kRound{20};

/// Time between two looks for room in a full ring.
constexpr std::chrono::microseconds kWaitForRoom{200};

/// Of a task; short enough that a string holds it without memory.
constexpr const char* kOutOfMemory = "out of memory";

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
  return default_recordings();
}

std::vector<std::string> list_recordings(const fs::path& folder) {
  std::vector<std::pair<fs::file_time_type, std::string>> found;
  std::error_code error;
  for (std::string& name : folder_names(folder)) {
    const fs::path path = folder / name;
    // What is no text cannot be told.
    if (path.extension() != ".mcap" || !google::protobuf::internal::IsStructurallyValidUTF8(name)) {
      continue;
    }
    found.emplace_back(fs::last_write_time(path, error), std::move(name));
  }
  std::sort(found.begin(), found.end());
  std::vector<std::string> names;
  names.reserve(found.size());
  for (auto& recording : found) names.push_back(std::move(recording.second));
  return names;
}

RecorderThread::RecorderThread(LoopChannels& channels, const v1::RecordHeader& header)
    : ticks_(channels.recorded), snapshots_(channels.snapshots), recorder_(recorder_options()) {
  recorder_.begin(header);
  thread_ = std::thread([this] { run(); });
}

RecorderThread::~RecorderThread() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_one();
  thread_.join();
  within_memory([&] { recorder_.stop(); });
}

void RecorderThread::post(Task task) {
  const std::lock_guard lock(mutex_);
  tasks_.push_back(std::move(task));
}

std::future<std::string> RecorderThread::order(std::function<std::string()> work,
                                               std::optional<bool> record) {
  auto outcome = std::make_shared<Outcome>();
  std::future<std::string> told = outcome->told.get_future();
  {
    const std::lock_guard lock(mutex_);
    tasks_.emplace_back([this, outcome = std::move(outcome), work = std::move(work)] {
      if (!within_memory([&] { outcome->error = work(); })) outcome->error = kOutOfMemory;
      outcomes_.push_back(outcome);
    });
    if (record) {
      asked_ = record;
      ++asks_;
    }
  }
  wake_.notify_one();
  return told;
}

void RecorderThread::announce(v1::SceneRecord record, SceneIndex index) {
  const std::lock_guard lock(mutex_);
  const std::uint32_t scene_id = record.scene_id();
  scenes_[scene_id] = {std::move(record), std::move(index)};
}

void RecorderThread::announce_change(v1::ParameterRecord record) {
  const std::lock_guard lock(mutex_);
  changes_[record.number()] = std::move(record);
}

void RecorderThread::forget_change(std::uint64_t number) {
  const std::lock_guard lock(mutex_);
  changes_.erase(number);
}

void RecorderThread::event(std::int64_t t_ns, v1::EventRecord record) {
  post([this, t_ns, record = std::move(record)] {
    recorder_.add(RecordKind::kEvent, static_cast<std::uint64_t>(t_ns), record);
  });
}

std::future<std::string> RecorderThread::start(fs::path path) {
  return order(
      [this, path = std::move(path)] {
        std::string error;
        const bool tried = within_memory([&] {
          if (!recorder_.start(path.string())) error = recorder_.status().error;
        });
        if (tried) return error;
        recorder_.refuse_start();
        return std::string(kOutOfMemory);
      },
      true);
}

std::future<std::string> RecorderThread::stop() {
  return order(
      [this] {
        take_ticks();
        recorder_.stop();
        return recorder_.status().error;
      },
      false);
}

std::future<std::string> RecorderThread::dump(fs::path path) {
  return order(
      [this, path = std::move(path)] {
        take_ticks();
        DumpResult result{path.string(), ""};
        if (!within_memory([&] { recorder_.dump(path.string(), result.error); })) {
          result.error = kOutOfMemory;
        }
        const std::lock_guard lock(mutex_);
        dumps_.push_back(result);
        return result.error;
      },
      std::nullopt);
}

RecordStatus RecorderThread::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

bool RecorderThread::will_record() const {
  const std::lock_guard lock(mutex_);
  return asked_.value_or(status_.recording);
}

std::vector<DumpResult> RecorderThread::take_dumps() {
  const std::lock_guard lock(mutex_);
  return std::exchange(dumps_, {});
}

void RecorderThread::make_room() {
  while (ticks_.size() > RecorderTicks::capacity() / 2 || snapshots_.size() > 1) {
    wake_.notify_one();
    std::this_thread::sleep_for(kWaitForRoom);
  }
}

// A snapshot stands right behind the tick it was made after; that of a tick that was lost stands
// before the next one.
void RecorderThread::take_snapshots(const Tick& tick, bool after) {
  while (const Snapshot* snapshot = snapshots_.front()) {
    const bool passed = snapshot->scene_id < tick.scene_id ||
                        (snapshot->scene_id == tick.scene_id && snapshot->next_tick <= tick.tick);
    const bool fits = snapshot->scene_id == tick.scene_id && snapshot->next_tick == tick.tick + 1;
    if (!passed && !(after && fits)) return;
    // One that there is no memory for is left out: its room is waited for.
    within_memory([&] { take_snapshot(*snapshot, tick.t_ns); });
    snapshots_.release();
  }
}

void RecorderThread::take_snapshot(const Snapshot& snapshot, std::int64_t t_ns) {
  v1::Snapshot record;
  to_record(snapshot, record);
  for (const auto& [path, assignment] : parameters_) *record.add_parameters() = assignment;
  recorder_.add(RecordKind::kSnapshot, static_cast<std::uint64_t>(t_ns), record);
}

void RecorderThread::take_change(const Tick& tick) {
  v1::ParameterRecord record;
  {
    const std::lock_guard lock(mutex_);
    auto announced = changes_.extract(tick.change);
    if (announced.empty()) return;
    record = std::move(announced.mapped());
  }
  record.set_tick(tick.tick);
  for (const v1::Assignment& assignment : record.assignments()) {
    parameters_[assignment.path()] = assignment;
  }
  recorder_.add(RecordKind::kParameters, static_cast<std::uint64_t>(tick.t_ns), record);
}

void RecorderThread::take_scene(const Tick& tick) {
  parameters_.clear();
  index_.reset();
  const std::lock_guard lock(mutex_);
  const auto announced = scenes_.find(tick.scene_id);
  if (announced != scenes_.end()) {
    recorder_.add(RecordKind::kScene, static_cast<std::uint64_t>(tick.t_ns),
                  announced->second.record);
    index_ = std::move(announced->second.index);
    scenes_.erase(scenes_.begin(), std::next(announced));
  }
  // Last: where it could not be recorded, the next tick tries again.
  scene_id_ = tick.scene_id;
}

void RecorderThread::take_tick(const Tick& tick) {
  take_snapshots(tick, false);
  if (tick.scene_id != scene_id_) take_scene(tick);
  if (tick.change != 0) take_change(tick);
  recorder_.tick(tick, index_ ? &*index_ : nullptr);
  take_snapshots(tick, true);
}

void RecorderThread::take_ticks() {
  while (ticks_.pop(*tick_)) {
    if (!within_memory([&] { take_tick(*tick_); })) recorder_.lost_ticks(1);
  }
  const std::uint64_t lost = ticks_.overflow();
  if (lost != lost_) recorder_.lost_ticks(lost - lost_);
  lost_ = lost;
}

void RecorderThread::round() {
  std::deque<Task> tasks;
  std::uint64_t asks = 0;
  {
    const std::lock_guard lock(mutex_);
    tasks.swap(tasks_);
    asks = asks_;
  }
  for (const Task& task : tasks) within_memory(task);
  take_ticks();
  within_memory([&] {
    recorder_.poll(static_cast<std::uint64_t>(monotonic_now_ns()));
    RecordStatus status = recorder_.status();
    const std::lock_guard lock(mutex_);
    status_ = std::move(status);
    if (asks == asks_) asked_.reset();
  });
  for (const std::shared_ptr<Outcome>& outcome : outcomes_) {
    outcome->told.set_value(std::move(outcome->error));
  }
  outcomes_.clear();
}

void RecorderThread::run() {
  name_thread("recorder");
  begin_role(ThreadRole::kRecorder);
  while (true) {
    within_memory([&] { round(); });
    std::unique_lock lock(mutex_);
    if (ending_) break;
    wake_.wait_for(lock, kRound);
  }
  within_memory([&] { round(); });
}

}  // namespace hapticd
