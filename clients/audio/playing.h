// A sound card and what plays on it, for as long as one JACK server lives. When the server's sample
// rate changes, everything that was worked out for the old one (strings, body, recordings) is made
// again for the new one, and events that were not due yet are ordered again. Not RT.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "clients/audio/audio_engine.h"
#include "clients/audio/event_player.h"
#include "clients/audio/jack_output.h"
#include "clients/audio/options.h"
#include "clients/audio/string_design.h"
#include "clients/audio/tone_files.h"
#include "hapticd/v1/scene.pb.h"
#include "hapticd/v1/state.pb.h"
#include "hapticd/v1/stream.pb.h"

namespace hapticd::audio {

/// All that is made for one sample rate.
struct Instrument {
  /// `folder`: recordings; empty: all strings are computed.
  Instrument(double rate_hz, double gain, const std::string& folder);

  Sound sound;
  AudioEngine engine;
  std::unique_ptr<ToneFiles> tones;
  EventPlayer player;
};

/// What has been played by all instruments so far.
struct PlayedTones {
  std::uint64_t tones = 0;       ///< events
  std::uint64_t unplayable = 0;  ///< of them
  std::uint64_t lost = 0;        ///< orders that found no room
  std::uint64_t played = 0;
  std::uint64_t late = 0;
  std::uint64_t stolen = 0;
  std::uint64_t broken = 0;
  double latest_ms = 0.0;
  double limited_s = 0.0;
};

class Playing {
 public:
  /// Opens the output and plays. Throws NoJackServer. `folder` as in Instrument.
  Playing(const Options& options, std::string folder);
  ~Playing();
  Playing(const Playing&) = delete;
  Playing& operator=(const Playing&) = delete;

  [[nodiscard]] JackOutput& output() noexcept { return *output_; }
  [[nodiscard]] const JackOutput& output() const noexcept { return *output_; }
  [[nodiscard]] double rate_hz() const noexcept { return instrument_->sound.rate_hz; }
  /// What could not be connected, one line each; asked once.
  [[nodiscard]] std::vector<std::string> connect(const Options& options);

  void set_scene(const v1::Scene& scene);
  /// An event, to be heard at due_ns of CLOCK_MONOTONIC.
  void play(const v1::Item& event, std::int64_t due_ns, std::int64_t now_ns);
  /// What a State repeats of strings that sound, to be heard at due_ns.
  void join(const v1::State& state, std::int64_t due_ns) {
    instrument_->player.join(state, due_ns);
  }
  /// Follows the sample rate of the server; true when it has changed. Takes as long as the
  /// recordings take to be read: until then there is silence.
  bool follow_rate(std::int64_t now_ns);

  /// Remarks about recordings that have not been printed yet, one line each.
  [[nodiscard]] std::vector<std::string> remarks();
  [[nodiscard]] PlayedTones counts() const;

 private:
  [[nodiscard]] static PlayedTones counts_of(const Instrument& instrument);
  /// Gives the memory of instruments back that the callback has left.
  void bury();

  double gain_;
  std::string folder_;
  std::unique_ptr<JackOutput> output_;
  std::unique_ptr<Instrument> instrument_;
  std::vector<std::unique_ptr<Instrument>> former_;
  PlayedTones buried_;
  std::uint64_t tones_ = 0;  ///< events; an instrument counts those again that it takes over
  std::optional<v1::Scene> scene_;
  std::deque<std::pair<std::int64_t, v1::Item>> waiting_;  ///< by due_ns, not due yet
  std::size_t problems_said_ = 0;
  std::size_t notes_said_ = 0;
};

}  // namespace hapticd::audio
