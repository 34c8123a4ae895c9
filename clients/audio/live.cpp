// See live.h.
#include "clients/audio/live.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>

#include "clients/audio/body_design.h"
#include "clients/audio/event_player.h"
#include "clients/audio/jack_output.h"
#include "clients/audio/tone_files.h"
#include "clients/library/client.h"
#include "clients/library/named_key.h"

namespace hapticd::audio {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
/// How often latency and clock of the sound card are looked at, and a server is looked for.
constexpr std::int64_t kLook_ns = kSecond_ns;
/// A daemon that is there has told its scene long before.
constexpr std::int64_t kPatience_ns = 3 * kSecond_ns;
/// From an event to its order, on a good network.
constexpr double kNetwork_ms = 1.0;
/// How often --verbose speaks.
constexpr std::int64_t kSpeak_ns = 10 * kSecond_ns;
/// Instants beyond this are no instants: 146 years.
constexpr std::uint64_t kMostInstant_ns = std::uint64_t{1} << 62U;

void say(const std::string& text) { std::fprintf(stderr, "haptic-audio: %s\n", text.c_str()); }

std::optional<std::uint64_t> instant_of(const v1::Item& item) {
  if (item.has_tone()) return item.tone().t_ns();
  if (item.has_string_radius()) return item.string_radius().t_ns();
  return std::nullopt;
}

/// A sound card and what plays on it; for as long as one JACK server lives.
struct Playing {
  Playing(const Options& options, const std::string& tones_folder)
      : output(std::make_unique<JackOutput>(options.name)),
        sound{output->rate_hz(), gain_of(options), design_body(output->rate_hz())},
        engine(std::make_unique<AudioEngine>(sound.body)) {
    if (!tones_folder.empty()) tones = std::make_unique<ToneFiles>(tones_folder, sound.rate_hz);
    player.emplace(sound, tones.get(),
                   [this](const Order& order) { return engine->submit(order); });
    output->start(*engine);
    if (options.no_connect) return;
    for (const std::string& problem : output->connect(options.connect)) say(problem);
  }
  // The callback ends before what it plays.
  ~Playing() { output.reset(); }
  Playing(const Playing&) = delete;
  Playing& operator=(const Playing&) = delete;

  std::unique_ptr<JackOutput> output;
  Sound sound;
  std::unique_ptr<AudioEngine> engine;
  std::unique_ptr<ToneFiles> tones;
  std::optional<EventPlayer> player;
  std::size_t problems_said = 0;
};

class Live {
 public:
  explicit Live(const Options& options)
      : options_(options),
        folder_(tones_folder(options)),
        delay_ns_(std::llround(options.delay_ms * 1e6)) {}

  /// Looks for a JACK server. Throws NoJackServer.
  void open_output() {
    playing_ = std::make_unique<Playing>(options_, folder_);
    char text[160];
    std::snprintf(text, sizeof text, "plays by JACK: %.0f Hz, blocks of %u, %.1f ms to the ear",
                  playing_->sound.rate_hz, playing_->output->block(),
                  playing_->output->latency() * 1e3 / playing_->sound.rate_hz);
    say(text);
    warn_of_delay();
    if (client_ && client_->scene()) set_scene(client_->scene()->scene());
  }

  void open_daemon() {
    client::ClientHandlers handlers;
    handlers.item = [this](const v1::Item& item) { take(item); };
    handlers.ended = [this](client::SessionEnd) {
      if (heard_) say("the daemon at " + client_->server() + " has gone; waits for it");
      missed_ = missed_ || heard_;
      heard_ = false;
    };
    client_.emplace(options_.host, options_.port, handlers, client::named_key(options_.key_file));
    opened_ns_ = client::monotonic_now_ns();
    say("listens to hapticd at " + client_->server());
  }

  /// A few milliseconds of it.
  void run() {
    client_->poll();
    const std::int64_t now_ns = client::monotonic_now_ns();
    if (now_ns >= look_ns_) {
      look_ns_ = now_ns + kLook_ns;
      look();
      miss_daemon(now_ns);
    }
    if (options_.verbose && now_ns >= speak_ns_) {
      speak_ns_ = now_ns + kSpeak_ns;
      say(report());
    }
  }

  [[nodiscard]] std::string report() const;

 private:
  void take(const v1::Item& item) {
    if (item.has_scene_info()) {
      if (!heard_) say("hears hapticd, scene " + item.scene_info().scene().name());
      heard_ = true;
      real_clock_ = item.scene_info().clock() != v1::CLOCK_MODE_VIRTUAL;
      set_scene(item.scene_info().scene());
    }
    const std::optional<std::uint64_t> instant = instant_of(item);
    if (!instant || !playing_) return;
    playing_->player->play(item, due_ns(*instant, client_->clock(), real_clock_,
                                        client::monotonic_now_ns(), delay_ns_));
  }

  /// A tone waits for the next block, which is heard after the latency.
  void warn_of_delay() {
    const double needed_ms =
        (playing_->output->latency() + playing_->output->block()) * 1e3 / playing_->sound.rate_hz +
        kNetwork_ms;
    if (needed_ms <= options_.delay_ms) return;
    char text[160];
    std::snprintf(text, sizeof text,
                  "%.1f ms are too short for blocks of %u, so some tones will be late. Start JACK "
                  "with smaller ones, or use --delay-ms %.0f",
                  options_.delay_ms, playing_->output->block(), std::ceil(needed_ms));
    say(text);
  }

  void set_scene(const v1::Scene& scene) {
    if (!playing_) return;
    playing_->player->set_scene(scene);
    if (!playing_->tones) return;
    const auto& problems = playing_->tones->problems();
    for (; playing_->problems_said < problems.size(); ++playing_->problems_said) {
      say(problems[playing_->problems_said] + ". The string is computed instead");
    }
  }

  void look() {
    if (playing_ && !playing_->output->alive()) {
      say("the JACK server has gone; waits for another");
      playing_.reset();
    }
    if (playing_) {
      playing_->output->refresh();
      return;
    }
    try_output();
  }

  /// A daemon with keys does not answer who has none of its own.
  void miss_daemon(std::int64_t now_ns) {
    if (heard_ || missed_ || now_ns - opened_ns_ < kPatience_ns) return;
    missed_ = true;
    say("no daemon answers at " + client_->server() +
        " yet. Start hapticd, or name where it listens with --server; if it has keys, give one of "
        "its own with --key");
  }

  void try_output() {
    try {
      open_output();
    } catch (const NoJackServer&) {
      playing_.reset();  // that there is none has been said; the next look is in a second
    }
  }

  const Options& options_;
  std::string folder_;
  std::int64_t delay_ns_;
  std::unique_ptr<Playing> playing_;
  std::optional<client::Client> client_;
  bool heard_ = false;
  bool missed_ = false;  ///< that it is has been said
  std::int64_t opened_ns_ = 0;
  bool real_clock_ = true;
  std::int64_t look_ns_ = 0;
  std::int64_t speak_ns_ = 0;
};

std::string Live::report() const {
  char text[320];
  if (!playing_) return "no sound card";
  const EventCounts& events = playing_->player->counts();
  const PlayCounts& counts = playing_->engine->counts();
  const client::ClientCore& core = client_->core();
  const client::ClockRelation clock =
      core.clock().known() ? core.clock().at(client::monotonic_now_ns()) : client::ClockRelation{};
  std::snprintf(
      text, sizeof text,
      "tones %llu, played %llu, late %llu (%.1f ms at most), ended early %llu, unplayable "
      "%llu, lost %llu; overruns %llu; clock %+.3f ms, +- %.3f ms",
      static_cast<unsigned long long>(events.tones),
      static_cast<unsigned long long>(counts.played.load()),
      static_cast<unsigned long long>(counts.late.load()),
      static_cast<double>(counts.latest_ns.load()) * 1e-6,
      static_cast<unsigned long long>(counts.stolen.load()),
      static_cast<unsigned long long>(events.unplayable),
      static_cast<unsigned long long>(events.lost),
      static_cast<unsigned long long>(playing_->output->overruns()),
      static_cast<double>(clock.offset_ns) * 1e-6,
      static_cast<double>(clock.uncertainty_ns) * 1e-6);
  return text;
}

}  // namespace

std::int64_t due_ns(std::uint64_t t_ns, const client::ClockEstimate& clock, bool real_clock,
                    std::int64_t now_ns, std::int64_t delay_ns) {
  if (!real_clock || !clock.known() || t_ns > kMostInstant_ns) return now_ns + delay_ns;
  return static_cast<std::int64_t>(t_ns) - clock.at(now_ns).offset_ns + delay_ns;
}

double gain_of(const Options& options) { return std::pow(10.0, options.gain_db / 20.0); }

std::string tones_folder(const Options& options) {
  if (options.synth) return {};
  if (options.tones) return *options.tones;
  std::error_code ignored;
  const std::filesystem::path shipped =
      std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path().parent_path() /
      "share" / "hapticd" / "tones";
  return std::filesystem::is_directory(shipped, ignored) ? shipped.string() : std::string();
}

int play_live(const Options& options, const volatile std::sig_atomic_t& stop) {
  Live live(options);
  try {
    live.open_output();
  } catch (const NoJackServer& problem) {
    say(problem.what());
    if (!options.wait) return kNoServer;
    say("waits for a JACK server");
  }
  live.open_daemon();
  while (stop == 0) live.run();
  say(live.report());
  return 0;
}

void list_ports() {
  const JackOutput output("haptic-audio-list");
  std::printf("%.0f Hz, blocks of %u\n", output.rate_hz(), output.block());
  for (const JackPort& port : output.ports()) {
    std::printf("%-5s %-9s %s\n", port.midi ? "midi" : "audio",
                port.hardware ? "hardware" : "program", port.name.c_str());
  }
}

}  // namespace hapticd::audio
