// The recorder's thread: takes the loop's ticks to the recorder, writes session files and dumps of
// the last 60 s. Asked by the network thread; only its own thread waits for the disk. Not RT.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "server/haptic_loop/haptic_loop.h"
#include "server/recorder/recorder.h"

namespace hapticd {

/// Where recordings are kept: $STATE_DIRECTORY, else $XDG_STATE_HOME/hapticd, else
/// ~/.local/state/hapticd, in the folder `recordings`.
[[nodiscard]] std::filesystem::path recordings_folder();

/// Names of the recordings in `folder`, newest last.
[[nodiscard]] std::vector<std::string> list_recordings(const std::filesystem::path& folder);

/// What a finished dump came to.
struct DumpResult {
  std::string file;
  std::string error;  ///< empty: written
};

class RecorderThread {
 public:
  /// Starts the thread. `channels` must outlive this.
  RecorderThread(LoopChannels& channels, const v1::RecordHeader& header);
  RecorderThread(const RecorderThread&) = delete;
  RecorderThread& operator=(const RecorderThread&) = delete;
  /// Closes the session file.
  ~RecorderThread();

  /// `record` is for the ticks whose scene_id is its own, and so is `index`; before their first
  /// one.
  void announce(v1::SceneRecord record, SceneIndex index);
  /// `record` is of the change of this number; before the loop is told of it. Its tick follows.
  void announce_change(v1::ParameterRecord record);
  /// The change of this number never begins.
  void forget_change(std::uint64_t number);
  void event(std::int64_t t_ns, v1::EventRecord record);

  /// Begins a session file. The future has what went wrong, and is empty where nothing did; it is
  /// ready once status(), or take_dumps(), tells of it.
  std::future<std::string> start(std::filesystem::path path);
  /// Ends and closes it.
  std::future<std::string> stop();
  /// Writes the last 60 s.
  std::future<std::string> dump(std::filesystem::path path);

  /// Waits until the rings of the loop, of ticks and of snapshots, are at most half full. Under
  /// virtual time, where ticks may come faster than they are written.
  void make_room();

  /// As of the last round of the thread.
  [[nodiscard]] RecordStatus status() const;
  /// Whether there is a session file, or will be, once all that was asked for has been tried.
  [[nodiscard]] bool will_record() const;
  /// Dumps that were finished since the last call.
  [[nodiscard]] std::vector<DumpResult> take_dumps();

 private:
  using Task = std::function<void()>;
  /// What came of something that was asked for.
  struct Outcome {
    std::promise<std::string> told;
    std::string error;
  };
  void post(Task task);
  /// Has the thread do `work`, which returns what went wrong. `record`: see asked_.
  std::future<std::string> order(std::function<std::string()> work, std::optional<bool> record);
  void run();
  void round();
  void take_ticks();
  void take_tick(const Tick& tick);
  void take_scene(const Tick& tick);
  void take_snapshots(const Tick& tick, bool after);
  void take_snapshot(const Snapshot& snapshot, std::int64_t t_ns);
  void take_change(const Tick& tick);

  /// A scene as it is recorded, and the numbers of its strings and lines.
  struct AnnouncedScene {
    v1::SceneRecord record;
    SceneIndex index;
  };

  RecorderTicks& ticks_;
  SnapshotRing& snapshots_;
  std::unique_ptr<Tick> tick_ = std::make_unique<Tick>();  ///< the newest taken
  Recorder recorder_;
  std::map<std::string, v1::Assignment> parameters_;  ///< set since the scene was loaded
  std::uint32_t scene_id_ = 0;
  std::optional<SceneIndex> index_;  ///< of that scene
  std::uint64_t lost_ = 0;
  std::vector<std::shared_ptr<Outcome>> outcomes_;  ///< of this round

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Task> tasks_;
  std::map<std::uint32_t, AnnouncedScene> scenes_;        ///< announced, not begun
  std::map<std::uint64_t, v1::ParameterRecord> changes_;  ///< announced, not begun, by number
  RecordStatus status_;
  std::optional<bool> asked_;  ///< what was asked last, and not tried yet: to record, or to stop
  std::uint64_t asks_ = 0;
  std::vector<DumpResult> dumps_;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace hapticd
