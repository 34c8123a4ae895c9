// A recording as a source, in place of a daemon: its events when their time comes, States at some
// 250 a second, faster, slower, from any place. Time is brought in by the owner. Not RT.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "clients/library/recording.h"
#include "hapticd/v1/gateway.pb.h"

namespace hapticd::web {

/// Fastest rate.
inline constexpr double kMaxRate = 100.0;
/// While it plays, a wanted position this near to its own is what a page sees of now, s: no jump.
inline constexpr double kSamePlace_s = 0.25;

struct PlaybackHandlers {
  std::function<void(const v1::State&)> state;
  std::function<void(const v1::Item&)> item;  ///< SceneInfo and events
};

class Playback {
 public:
  /// Throws std::runtime_error as client::Recording does, and for a recording without ticks.
  Playback(const std::filesystem::path& file, PlaybackHandlers handlers);

  /// Shows the first tick and plays on.
  void begin();
  /// `elapsed_s` of the owner's clock have gone by.
  void advance(double elapsed_s);
  /// Goes where and plays as `wanted` says.
  void steer(const v1::PagePlayback& wanted);

  [[nodiscard]] v1::PagePlayback position() const;
  /// Nothing of the file is missing, client::Recording::whole().
  [[nodiscard]] bool whole() const noexcept { return recording_.whole(); }
  /// Its ticks hold tools and devices alone: it is of a format before strings and contacts.
  [[nodiscard]] bool tools_only() const noexcept;
  /// The daemon's clock at the position, ns.
  [[nodiscard]] std::int64_t shown_t_ns() const;

 private:
  struct Tick {
    std::uint64_t time_ns;
    std::size_t message;
  };

  void seek(double position_s);
  /// Tells of a scene or an event.
  void tell(std::size_t message);
  void tell_scene(std::size_t message);
  void show(std::size_t tick);
  [[nodiscard]] double length_s() const;
  [[nodiscard]] std::uint64_t time_at(double position_s) const;
  /// Number of ticks whose time is not after `time_ns`.
  [[nodiscard]] std::size_t ticks_until(std::uint64_t time_ns) const;

  client::Recording recording_;
  PlaybackHandlers handlers_;
  std::vector<Tick> ticks_;
  std::vector<std::size_t> scenes_;         ///< messages
  std::size_t next_ = 0;                    ///< message that was not taken yet
  std::optional<std::size_t> shown_scene_;  ///< message
  std::uint64_t shown_tick_time_ns_ = 0;
  std::uint64_t shown_tick_t_ns_ = 0;
  double position_s_ = 0.0;
  double rate_ = 1.0;
  bool playing_ = false;
};

}  // namespace hapticd::web
