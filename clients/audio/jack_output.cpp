// See jack_output.h.
#include "clients/audio/jack_output.h"

#include <jack/midiport.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <nlohmann/json.hpp>

#include "clients/library/client.h"

namespace hapticd::audio {
namespace {

/// Measurements of the difference of two clocks, of which the quickest counts.
constexpr int kClockLooks = 5;
constexpr std::uint8_t kMidiChannels = 16;

/// libjack writes to stderr what this program says in a better way.
void say_nothing(const char* /*message*/) {}

std::string reason(jack_status_t status) {
  if ((status & JackServerFailed) != 0) {
    return "no JACK server runs. Start one: jackd -d alsa -r 48000 -p 128; or, on a desktop with "
           "PipeWire, run: pw-jack haptic-audio. Without a sound card: haptic-audio --render FILE";
  }
  if ((status & JackShmFailure) != 0) {
    return "the JACK server's shared memory cannot be reached. Run haptic-audio as the user who "
           "runs the server";
  }
  if ((status & JackVersionError) != 0) {
    return "the JACK server and libjack have different versions. Update both";
  }
  return "the JACK server refuses a client (status " + std::to_string(status) +
         "). It may have stopped; restart it";
}

}  // namespace

JackOutput::JackOutput(const std::string& name) {
  jack_set_error_function(say_nothing);
  jack_set_info_function(say_nothing);
  jack_status_t status{};
  client_.reset(jack_client_open(name.c_str(), JackNoStartServer, &status));
  if (!client_) throw NoJackServer(reason(status));
  audio_ = jack_port_register(client_.get(), "out", JACK_DEFAULT_AUDIO_TYPE,
                              JackPortIsOutput | JackPortIsTerminal, 0);
  midi_ = jack_port_register(client_.get(), "notes", JACK_DEFAULT_MIDI_TYPE,
                             JackPortIsOutput | JackPortIsTerminal, 0);
  if (audio_ == nullptr || midi_ == nullptr) {
    throw NoJackServer("the JACK server has no port left. Start it with more: jackd -p N");
  }
  jack_set_process_callback(client_.get(), process, this);
  jack_set_xrun_callback(client_.get(), overrun, this);
  jack_set_sample_rate_callback(client_.get(), change, this);
  jack_set_buffer_size_callback(client_.get(), change, this);
  jack_on_shutdown(client_.get(), gone, this);
}

std::string ports_json(const std::vector<JackPort>& ports) {
  using Json = nlohmann::ordered_json;
  Json json = {{"playback", Json::array()}, {"notes", Json::array()}};
  for (const JackPort& port : ports) {
    json[port.midi ? "notes" : "playback"].push_back(
        {{"port", port.name}, {"hardware", port.hardware}});
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

JackOutput::~JackOutput() = default;

double JackOutput::rate_hz() const { return jack_get_sample_rate(client_.get()); }

std::uint32_t JackOutput::block() const { return jack_get_buffer_size(client_.get()); }

std::vector<JackPort> JackOutput::ports() const {
  std::vector<JackPort> found;
  for (const bool midi : {false, true}) {
    const char** const names =
        jack_get_ports(client_.get(), nullptr,
                       midi ? JACK_DEFAULT_MIDI_TYPE : JACK_DEFAULT_AUDIO_TYPE, JackPortIsInput);
    for (const char** name = names; name != nullptr && *name != nullptr; ++name) {
      const jack_port_t* const port = jack_port_by_name(client_.get(), *name);
      const bool hardware = port != nullptr && (jack_port_flags(port) & JackPortIsPhysical) != 0;
      found.push_back({*name, midi, hardware});
    }
    jack_free(static_cast<void*>(names));
  }
  return found;
}

void JackOutput::play(AudioEngine& engine) noexcept {
  engine_.store(&engine, std::memory_order_release);
}

bool JackOutput::plays(const AudioEngine& engine) const noexcept {
  return rendered_.load(std::memory_order_acquire) == &engine;
}

void JackOutput::start() {
  refresh();
  if (jack_activate(client_.get()) != 0)
    throw NoJackServer("the JACK server does not let the client play");
}

std::vector<std::string> JackOutput::connect(const std::vector<std::string>& names) {
  std::vector<std::string> wanted = names;
  if (wanted.empty()) {
    for (const JackPort& port : ports()) {
      if (port.hardware && !port.midi && wanted.size() < 2) wanted.push_back(port.name);
    }
  }
  std::vector<std::string> problems;
  if (wanted.empty())
    problems.emplace_back("the JACK server has no playback port; connect port 'out' by hand");
  for (const std::string& name : wanted) {
    const int failure = jack_connect(client_.get(), jack_port_name(audio_), name.c_str());
    if (failure != 0 && failure != EEXIST) {
      problems.push_back("there is no port " + name +
                         ". haptic-audio --list names those there are");
    }
  }
  refresh();
  return problems;
}

void JackOutput::refresh() {
  jack_latency_range_t range{};
  jack_port_get_latency_range(audio_, JackPlaybackLatency, &range);
  latency_.store(range.max, std::memory_order_relaxed);

  std::int64_t shortest = INT64_MAX;
  for (int look = 0; look < kClockLooks; ++look) {
    const std::int64_t before = client::monotonic_now_ns();
    const auto jack_ns = static_cast<std::int64_t>(jack_get_time()) * 1000;
    const std::int64_t took = client::monotonic_now_ns() - before;
    if (took >= shortest) continue;
    shortest = took;
    clock_offset_ns_.store(before + took / 2 - jack_ns, std::memory_order_relaxed);
  }
}

int JackOutput::process(jack_nframes_t frames, void* self) {
  static_cast<JackOutput*>(self)->render(frames);
  return 0;
}

void JackOutput::render(jack_nframes_t frames) noexcept {
  AudioEngine* const engine = engine_.load(std::memory_order_acquire);
  const AudioEngine* const before = rendered_.exchange(engine, std::memory_order_acq_rel);
  jack_nframes_t cycle_frame = 0;
  jack_time_t begin_us = 0;
  jack_time_t next_us = 0;
  float period_us = 0.0F;
  const double rate_hz = jack_get_sample_rate(client_.get());
  FrameClock clock;
  clock.frame = frame_;
  clock.ns_per_frame = 1e9 / rate_hz;
  if (jack_get_cycle_times(client_.get(), &cycle_frame, &begin_us, &next_us, &period_us) == 0 &&
      period_us > 0.0F) {
    clock.ns_per_frame = 1e3 * static_cast<double>(period_us) / frames;
  } else {
    begin_us = jack_get_time();
  }
  clock.heard_ns = static_cast<std::int64_t>(begin_us) * 1000 +
                   clock_offset_ns_.load(std::memory_order_relaxed) +
                   static_cast<std::int64_t>(latency() * 1e9 / rate_hz);

  auto* const samples = static_cast<float*>(jack_port_get_buffer(audio_, frames));
  if (engine->rate_hz() == rate_hz) {
    engine->render(clock, frame_, {samples, frames}, notes_);
  } else {
    std::fill_n(samples, frames, 0.0F);
    notes_.count = 0;
  }
  frame_ += frames;
  write_notes(frames, before != nullptr && before != engine);
}

void JackOutput::write_notes(jack_nframes_t frames, bool other_engine) noexcept {
  void* const midi = jack_port_get_buffer(midi_, frames);
  jack_midi_clear_buffer(midi);
  if (other_engine) {
    // Nothing else ends what an engine before this one has begun.
    for (std::uint8_t channel = 0; channel < kMidiChannels; ++channel) {
      const std::array<std::uint8_t, 3> all_off{static_cast<std::uint8_t>(0xB0U | channel), 123, 0};
      jack_midi_event_write(midi, 0, all_off.data(), all_off.size());
    }
  }
  for (std::size_t i = 0; i < notes_.count; ++i) {
    const MidiEvent& event = notes_.events[i];
    jack_midi_event_write(midi, static_cast<jack_nframes_t>(event.frame), event.bytes.data(),
                          event.bytes.size());
  }
}

int JackOutput::overrun(void* self) {
  static_cast<JackOutput*>(self)->overruns_.fetch_add(1, std::memory_order_relaxed);
  return 0;
}

int JackOutput::change(jack_nframes_t /*value*/, void* self) {
  static_cast<JackOutput*>(self)->changed_.store(true, std::memory_order_relaxed);
  return 0;
}

void JackOutput::gone(void* self) {
  static_cast<JackOutput*>(self)->alive_.store(false, std::memory_order_relaxed);
}

}  // namespace hapticd::audio
