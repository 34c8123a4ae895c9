// See live.h.
#include "clients/audio/live.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>

#include "clients/audio/jack_output.h"
#include "clients/audio/playing.h"
#include "clients/library/program.h"
#include "proto/wire/shown_text.h"

namespace hapticd::audio {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
/// How often latency and clock of the sound card are looked at, and a server is looked for.
constexpr std::int64_t kLook_ns = kSecond_ns;
/// A daemon that is there has sent its scene long before.
constexpr std::int64_t kPatience_ns = 3 * kSecond_ns;
/// From an event to its order, on a good network.
constexpr double kNetwork_ms = 1.0;
/// Changes of the delay that is needed below this are none.
constexpr double kSameDelay_ms = 0.5;
/// How often --verbose reports, and late tones are reported at most.
constexpr std::int64_t kSpeak_ns = 10 * kSecond_ns;
/// Instants beyond this are no instants: 146 years.
constexpr std::uint64_t kMaxInstant_ns = std::uint64_t{1} << 62U;
/// States per second: they repeat what sounds for who has come late, or for an instrument that was
/// made anew. Faster than it is repeated, so that what had no room in one follows soon.
constexpr double kStates_hz = 50.0;
/// Of a daemon that does not say how many ticks a second has.
constexpr double kUsualRate_hz = 1000.0;

void say(const std::string& text) {
  std::fprintf(stderr, "haptic-audio: %s\n", wire::shown_lines(text).c_str());
}

std::optional<std::uint64_t> instant_of(const v1::Item& item) {
  if (item.has_tone()) return item.tone().t_ns();
  if (item.has_string_radius()) return item.string_radius().t_ns();
  if (item.has_string_sounding()) return item.string_sounding().t_ns();
  return std::nullopt;
}

class Live {
 public:
  explicit Live(const Options& options)
      : options_(options),
        folder_(tones_folder(options)),
        delay_ms_(options.delay_ms.value_or(kDelay_ms)) {}

  /// Looks for a JACK server. Throws NoJackServer.
  void open_output() {
    playing_ = std::make_unique<Playing>(options_, folder_);
    for (const std::string& problem : playing_->connect(options_)) say(problem);
    late_said_ = overruns_said_ = 0;
    say_card("plays by JACK");
    judge_delay();
    if (client_ && client_->scene()) set_scene(client_->scene()->scene());
  }

  void open_daemon() {
    client::ClientHandlers handlers;
    handlers.item = [this](const v1::Item& item) { take(item); };
    handlers.state = [this](const v1::State& state) { join(state); };
    handlers.ended = [this](client::SessionEnd) {
      if (heard_) say("the daemon at " + client_->server() + " has gone; waits for it");
      missed_ = missed_ || heard_;
      heard_ = false;
    };
    client_ = client::open_client(options_.daemon, handlers);
    opened_ns_ = client::monotonic_now_ns();
    say("listens to hapticd at " + client_->server());
  }

  /// A few milliseconds of it.
  void run() {
    client_->poll();
    const std::int64_t now_ns = client::monotonic_now_ns();
    if (playing_ && playing_->output().has_changed()) follow();
    if (now_ns >= look_ns_) {
      look_ns_ = now_ns + kLook_ns;
      look(now_ns);
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
      real_clock_ = item.scene_info().clock() != v1::CLOCK_MODE_VIRTUAL;
      set_scene(item.scene_info().scene());
      subscribe(item.scene_info().rate_hz());
      if (!heard_) say("hears hapticd, scene " + item.scene_info().scene().name());
      heard_ = true;
    }
    const std::optional<std::uint64_t> instant = instant_of(item);
    if (!instant || !playing_) return;
    const std::int64_t now_ns = client::monotonic_now_ns();
    playing_->play(item, heard_at(*instant, now_ns), now_ns);
  }

  /// What sounded before we came is in States alone.
  void subscribe(double rate_hz) {
    v1::Item item;
    const double ticks = (rate_hz > 0.0 ? rate_hz : kUsualRate_hz) / kStates_hz;
    item.mutable_subscribe()->set_divisor(
        static_cast<std::uint32_t>(std::clamp(std::round(ticks), 1.0, 1e6)));
    item.mutable_subscribe()->add_sections(v1::SECTION_STRINGS);
    client_->request(item);
  }

  void join(const v1::State& state) {
    // The numbers of one scene's strings say nothing of another's.
    const bool known = client_->scene() && client_->scene()->scene_id() == state.scene_id();
    if (!known || !playing_) return;
    playing_->join(state, heard_at(state.t_ns(), client::monotonic_now_ns()));
  }

  [[nodiscard]] std::int64_t heard_at(std::uint64_t t_ns, std::int64_t now_ns) const {
    return due_ns(t_ns, client_->clock(), real_clock_, now_ns, std::llround(delay_ms_ * 1e6));
  }

  void say_card(const char* begin) {
    const JackOutput& output = playing_->output();
    char text[160];
    std::snprintf(text, sizeof text, "%s: %.0f Hz, blocks of %u, %.1f ms to the ear", begin,
                  output.rate_hz(), output.block(), output.latency() * 1e3 / output.rate_hz());
    say(text);
  }

  /// A tone waits for the next block, which is heard after the latency.
  [[nodiscard]] double needed_ms() const {
    const JackOutput& output = playing_->output();
    return (output.latency() + output.block()) * 1e3 / output.rate_hz() + kNetwork_ms;
  }

  /// Whether the delay suffices for the sound card as it is now, said where that changes. A delay
  /// that nobody has given grows to what suffices: tones that are all equally later keep their
  /// rhythm, tones that are late by chance do not.
  void judge_delay() {
    const double needed = needed_ms();
    if (std::abs(needed - judged_ms_) < kSameDelay_ms) return;
    judged_ms_ = needed;
    const unsigned block = playing_->output().block();
    const bool was_short = short_;
    short_ = options_.delay_ms && needed > *options_.delay_ms;
    char text[320];
    if (short_) {
      std::snprintf(text, sizeof text,
                    "%.1f ms are too short for blocks of %u, so some tones will be late. Start "
                    "JACK with smaller ones, or use --delay-ms %.0f",
                    delay_ms_, block, std::ceil(needed));
      say(text);
    } else if (was_short) {
      std::snprintf(text, sizeof text, "%.1f ms suffice for blocks of %u", delay_ms_, block);
      say(text);
    }
    if (!options_.delay_ms) lengthen_delay(std::max(kDelay_ms, std::ceil(needed)), block);
  }

  void lengthen_delay(double wanted_ms, unsigned block) {
    if (wanted_ms == delay_ms_) return;
    delay_ms_ = wanted_ms;
    char text[320];
    if (wanted_ms > kDelay_ms) {
      std::snprintf(text, sizeof text,
                    "blocks of %u need a delay of %.0f ms: from now on tones are heard that long "
                    "after they happen; %.0f ms are usual. To keep the page in step, start "
                    "haptic-web with --delay %.3f; or start JACK with smaller blocks",
                    block, wanted_ms, kDelay_ms, wanted_ms * 1e-3);
    } else {
      std::snprintf(text, sizeof text, "from now on tones are heard %.0f ms after they happen",
                    wanted_ms);
    }
    say(text);
  }

  void set_scene(const v1::Scene& scene) {
    if (!playing_) return;
    playing_->set_scene(scene);
    say_remarks();
  }

  void say_remarks() {
    for (const std::string& line : playing_->remarks()) say(line);
  }

  /// The server's sample rate or blocks are others now.
  void follow() {
    playing_->output().refresh();
    if (playing_->follow_rate(client::monotonic_now_ns())) {
      say_card("the sample rate has changed");
      say_remarks();
    }
    judge_delay();
  }

  void look(std::int64_t now_ns) {
    if (playing_ && !playing_->output().alive()) {
      say("the JACK server has gone; waits for another");
      playing_.reset();
    }
    if (playing_) {
      follow();
      if (now_ns >= trouble_ns_ && say_trouble()) trouble_ns_ = now_ns + kSpeak_ns;
      return;
    }
    try_output();
  }

  /// Tones that were late, and blocks that were, since it was said last.
  bool say_trouble() {
    const PlayedTones counts = playing_->counts();
    const std::uint64_t overruns = playing_->output().overruns();
    char text[200];
    const bool late = counts.late > late_said_;
    if (late) {
      std::snprintf(text, sizeof text,
                    "%llu of %llu tones have been late so far, by %.1f ms at most",
                    static_cast<unsigned long long>(counts.late),
                    static_cast<unsigned long long>(counts.played), counts.latest_ms);
      say(text);
    }
    const bool overrun = overruns > overruns_said_;
    if (overrun) {
      std::snprintf(
          text, sizeof text,
          "JACK has counted %llu overruns so far: this machine is too busy for its blocks",
          static_cast<unsigned long long>(overruns));
      say(text);
    }
    late_said_ = counts.late;
    overruns_said_ = overruns;
    return late || overrun;
  }

  /// A daemon with keys does not answer a client without one.
  void miss_daemon(std::int64_t now_ns) {
    if (heard_ || missed_ || now_ns - opened_ns_ < kPatience_ns) return;
    missed_ = true;
    say(client::unanswered(client_->server()));
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
  double delay_ms_;
  double judged_ms_ = 0.0;  ///< the delay that was needed when it was last judged
  bool short_ = false;      ///< that the delay given is too short has been said
  std::unique_ptr<Playing> playing_;
  std::unique_ptr<client::Client> client_;
  bool heard_ = false;
  bool missed_ = false;  ///< that it is has been said
  std::int64_t opened_ns_ = 0;
  bool real_clock_ = true;
  std::int64_t look_ns_ = 0;
  std::int64_t speak_ns_ = 0;
  std::int64_t trouble_ns_ = 0;
  std::uint64_t late_said_ = 0;
  std::uint64_t overruns_said_ = 0;
};

std::string Live::report() const {
  char text[400];
  if (!playing_) return "no sound card";
  const PlayedTones counts = playing_->counts();
  const client::ClientCore& core = client_->core();
  const wire::ClockRelation clock =
      core.clock().known() ? core.clock().at(client::monotonic_now_ns()) : wire::ClockRelation{};
  const auto number = [](std::uint64_t count) { return static_cast<unsigned long long>(count); };
  std::snprintf(
      text, sizeof text,
      "tones %llu, played %llu, late %llu (%.1f ms at most), ended early %llu, unplayable "
      "%llu, lost %llu, broken %llu; limited %.2f s; overruns %llu; clock %+.3f ms, +- "
      "%.3f ms",
      number(counts.tones), number(counts.played), number(counts.late), counts.latest_ms,
      number(counts.stolen), number(counts.unplayable), number(counts.lost), number(counts.broken),
      counts.limited_s, number(playing_->output().overruns()),
      static_cast<double>(clock.offset_ns) * 1e-6,
      static_cast<double>(clock.uncertainty_ns) * 1e-6);
  return text;
}

}  // namespace

std::int64_t due_ns(std::uint64_t t_ns, const wire::ClockEstimate& clock, bool real_clock,
                    std::int64_t now_ns, std::int64_t delay_ns) {
  if (!real_clock || !clock.known() || t_ns > kMaxInstant_ns) return now_ns + delay_ns;
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

int play_live(const Options& options) {
  client::end_on_signals();
  Live live(options);
  try {
    live.open_output();
  } catch (const NoJackServer& problem) {
    say(problem.what());
    if (!options.wait) return kNoServer;
    say("waits for a JACK server");
  }
  live.open_daemon();
  while (!client::has_ended()) live.run();
  say(live.report());
  return 0;
}

void list_ports(bool json) {
  const JackOutput output("haptic-audio-list");
  if (json) {
    std::fputs(ports_json(output.ports()).c_str(), stdout);
    return;
  }
  std::printf("%.0f Hz, blocks of %u\n", output.rate_hz(), output.block());
  for (const JackPort& port : output.ports()) {
    std::printf("%-5s %-9s %s\n", port.midi ? "midi" : "audio",
                port.hardware ? "hardware" : "program", port.name.c_str());
  }
}

}  // namespace hapticd::audio
