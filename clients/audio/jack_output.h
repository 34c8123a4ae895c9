// The sound card, by JACK (also PipeWire, with pw-jack): one audio port, one MIDI port, and the
// clock of what is heard. The callback renders out of the engine and does nothing else; while the
// server runs at another sample rate than the engine it is silent, so that no pitch is ever wrong.
// Servers come and go: a JackOutput lives as long as one server, and another is made for the next.
// It never starts a server. Not RT, except the callback.
#pragma once

#include <jack/jack.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "clients/audio/audio_engine.h"

namespace hapticd::audio {

/// No server runs, or it refused; what() says which, and the remedy.
class NoJackServer : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A port of the server that sound or notes can go to.
struct JackPort {
  std::string name;
  bool midi = false;
  bool hardware = false;
};

/// The ports as one JSON object in one line, for programs: playback has those for sound, notes
/// those for MIDI.
[[nodiscard]] std::string ports_json(const std::vector<JackPort>& ports);

class JackOutput {
 public:
  /// Opens a client called `name`, or nearly so when there is one already. Throws NoJackServer.
  explicit JackOutput(const std::string& name);
  ~JackOutput();
  JackOutput(const JackOutput&) = delete;
  JackOutput& operator=(const JackOutput&) = delete;

  /// Sample rate, Hz, and frames of a block, as they are now: both may change.
  [[nodiscard]] double rate_hz() const;
  [[nodiscard]] std::uint32_t block() const;
  /// Where sound and notes can go.
  [[nodiscard]] std::vector<JackPort> ports() const;

  /// From its next block on the callback renders out of `engine`, which lives until this ends, or
  /// until plays() says that another one is played.
  void play(AudioEngine& engine) noexcept;
  /// The callback renders out of `engine` and none before it.
  [[nodiscard]] bool plays(const AudioEngine& engine) const noexcept;
  /// Begins; play() comes first. Throws NoJackServer.
  void start();
  /// Connects the audio port to each of `names`; without any, to the first two of the hardware.
  /// What failed, for people, one line each.
  std::vector<std::string> connect(const std::vector<std::string>& names);
  /// Updates latency and clock; now and then, from the thread that made this.
  void refresh();

  /// Sample rate or blocks have changed since this was asked last.
  [[nodiscard]] bool has_changed() noexcept {
    return changed_.exchange(false, std::memory_order_relaxed);
  }
  /// The server is still there.
  [[nodiscard]] bool alive() const noexcept { return alive_.load(std::memory_order_relaxed); }
  /// From the callback's block to the ear, by what the server reports, frames.
  [[nodiscard]] std::uint32_t latency() const noexcept {
    return latency_.load(std::memory_order_relaxed);
  }
  /// Blocks that came too late, as the server counts.
  [[nodiscard]] std::uint64_t overruns() const noexcept {
    return overruns_.load(std::memory_order_relaxed);
  }

 private:
  static int process(jack_nframes_t frames, void* self);
  static int overrun(void* self);
  static int change(jack_nframes_t value, void* self);
  static void gone(void* self);

  struct Close {
    void operator()(jack_client_t* client) const { jack_client_close(client); }
  };

  /// One block of the callback.
  void render(jack_nframes_t frames) noexcept;
  void write_notes(jack_nframes_t frames, bool other_engine) noexcept;

  std::atomic<AudioEngine*> engine_{nullptr};          ///< to be played
  std::atomic<const AudioEngine*> rendered_{nullptr};  ///< by the last block
  jack_port_t* audio_ = nullptr;
  jack_port_t* midi_ = nullptr;
  std::int64_t frame_ = 0;  ///< frames rendered
  MidiEvents notes_;
  std::atomic<bool> alive_{true};
  std::atomic<bool> changed_{false};
  std::atomic<std::uint32_t> latency_{0};
  std::atomic<std::int64_t> clock_offset_ns_{0};  ///< CLOCK_MONOTONIC minus JACK's clock
  std::atomic<std::uint64_t> overruns_{0};
  /// Last: it is closed before what the callback uses.
  std::unique_ptr<jack_client_t, Close> client_;
};

}  // namespace hapticd::audio
