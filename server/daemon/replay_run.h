// A recording played again: its ticks, scenes and changes given to a loop whose devices are
// replayed ones, and what comes of them compared with what was recorded, bit for bit. The loop is
// stepped by the caller. Begins with the first tick of a daemon's life or at the first Snapshot,
// and goes on at the next Snapshot behind ticks that were lost. Not RT.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "proto/recording/recording_reader.h"
#include "server/haptic_loop/haptic_loop.h"
#include "server/recorder/tick_difference.h"

namespace hapticd {

/// What a replay has come to.
struct ReplayReport {
  std::uint64_t ticks = 0;            ///< played
  std::uint64_t different_ticks = 0;  ///< of them
  std::uint64_t states = 0;           ///< Snapshots compared
  std::uint64_t different_states = 0;
  std::uint64_t skipped_ticks = 0;  ///< recorded, but not played: there was nothing to start from
  std::uint64_t gaps = 0;           ///< places where the recorder lost ticks
  std::string first_difference;     ///< where and what, for people; empty: none
};

class ReplayRun {
 public:
  /// Makes what plays of a recorded scene, or throws.
  using MakeScene = std::function<std::unique_ptr<PlayedScene>(const v1::SceneRecord&)>;

  /// Opens a recording and looks through it. Throws RecordingError, also when it has no place to
  /// start from.
  explicit ReplayRun(const std::string& path);

  [[nodiscard]] const v1::RecordHeader& header() const noexcept { return reader_.header(); }
  [[nodiscard]] const RecordingSummary& summary() const noexcept { return summary_; }
  [[nodiscard]] const std::string& path() const noexcept { return reader_.path(); }
  /// What of its ticks can be compared: poses alone where the recording is of other physics.
  [[nodiscard]] Compared compared() const noexcept;
  /// The scene it starts with.
  [[nodiscard]] const v1::SceneRecord& first_scene() const noexcept { return scene_; }

  /// The loop to play with, which is in its first state and plays first_scene(); `channels` are
  /// its. `make_scene` is for those that follow. With `verify` all is compared. Throws
  /// RecordingError when the state to start from does not fit.
  void begin(HapticLoop& loop, LoopChannels& channels, MakeScene make_scene, bool verify);

  /// Finds the next tick; false at the end. Throws RecordingError, or what `make_scene` does.
  bool fetch();
  /// The tick that fetch() found.
  [[nodiscard]] const Tick& tick() const noexcept { return *tick_; }
  /// Plays it. Events and ticks are in the loop's channels.
  void play();

  [[nodiscard]] const ReplayReport& report() const noexcept { return report_; }

 private:
  void find_start();
  void take_scene(const RecordedMessage& message);
  void take_snapshot(const RecordedMessage& message);
  bool take_tick(const RecordedMessage& message);
  void restore(const Snapshot& snapshot);
  void begin_change();
  void compare_tick();
  void compare_state(const Snapshot& recorded);
  void note(std::uint64_t tick, std::uint32_t scene_id, const std::string& what);
  [[noreturn]] void fail(const std::string& what) const;
  template <typename Message>
  [[nodiscard]] Message parse(const RecordedMessage& message) const;

  RecordingReader reader_;
  RecordingSummary summary_;
  v1::SceneRecord scene_;  ///< of the ticks that come
  HapticLoop* loop_ = nullptr;
  LoopChannels* channels_ = nullptr;
  MakeScene make_scene_;
  bool verify_ = false;
  bool in_step_ = false;  ///< the loop is where the recording is
  std::optional<v1::ParameterRecord> change_;
  std::unique_ptr<Snapshot> snapshot_;  ///< to start from, or the last one read
  std::unique_ptr<Snapshot> replayed_;  ///< the loop's own
  std::unique_ptr<Tick> tick_;
  std::unique_ptr<Tick> again_;  ///< as it was played
  bool has_tick_ = false;        ///< tick_ waits to be played
  bool has_snapshot_ = false;    ///< snapshot_ is what to start from
  ReplayReport report_;
};

}  // namespace hapticd
