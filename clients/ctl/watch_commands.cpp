// status and watch: what the daemon does, once or live. Not RT.
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <memory>

#include "clients/ctl/commands.h"
#include "clients/ctl/text.h"
#include "clients/ctl/view.h"

namespace hapticd::ctl {
namespace {

/// How often the screen is drawn, s.
constexpr double kRedraw = 0.1;
/// How long status waits for a State: with the virtual clock at rest none may come.
constexpr std::chrono::milliseconds kStateWait{500};
constexpr std::size_t kTonesShown = 5;
/// States per second asked for.
constexpr double kWatchRate = 100.0;

const std::vector<v1::Section> kSections{
    v1::SECTION_TOOLS,   v1::SECTION_STRINGS,  v1::SECTION_CONTACTS, v1::SECTION_TIMING,
    v1::SECTION_STAGES,  v1::SECTION_ENERGY,   v1::SECTION_QUALITY,  v1::SECTION_STIFFNESS,
    v1::SECTION_DEVICES, v1::SECTION_GESTURES, v1::SECTION_REPLAY};

std::atomic<bool> over{false};
static_assert(std::atomic<bool>::is_always_lock_free);

void end_watch(int /*signal*/) { over.store(true); }

/// The terminal without echo and line mode, on its second screen; put back at the end.
class Terminal {
 public:
  Terminal() {
    if (tcgetattr(STDIN_FILENO, &before_) == 0) {
      termios raw = before_;
      raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
      changed_ = tcsetattr(STDIN_FILENO, TCSANOW, &raw) == 0;
    }
    write_all("\x1b[?1049h\x1b[?25l");
  }
  ~Terminal() {
    write_all("\x1b[?25h\x1b[?1049l");
    if (changed_) tcsetattr(STDIN_FILENO, TCSANOW, &before_);
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  /// Columns and rows as they are now.
  [[nodiscard]] static winsize size() {
    winsize size{};
    if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) {
      size.ws_col = 80;
      size.ws_row = 24;
    }
    return size;
  }
  /// A key that was pressed; 0: none.
  [[nodiscard]] static char key() {
    pollfd wanted{STDIN_FILENO, POLLIN, 0};
    char pressed = 0;
    if (::poll(&wanted, 1, 0) <= 0 || ::read(STDIN_FILENO, &pressed, 1) != 1) return 0;
    return pressed;
  }
  static void draw(const std::vector<std::string>& lines) {
    std::string text = "\x1b[H";
    for (std::size_t i = 0; i < lines.size(); ++i) {
      text += lines[i] + "\x1b[K" + (i + 1 < lines.size() ? "\r\n" : "");
    }
    write_all(text + "\x1b[J");
  }

 private:
  static void write_all(const std::string& text) {
    std::fwrite(text.data(), 1, text.size(), stdout);
    std::fflush(stdout);
  }

  termios before_{};
  bool changed_ = false;
};

View view_of(const client::Client& client) {
  View view;
  view.server = client.server();
  if (client.scene()) view.scene = *client.scene();
  view.has_state = client.state().has_value();
  if (view.has_state) view.state = *client.state();
  view.lease = client.lease();
  view.silence_s =
      1e-9 * static_cast<double>(client::monotonic_now_ns() - client.core().heard_ns());
  return view;
}

void status(const GlobalOptions& options) {
  const auto client = connect(options);
  require(client->subscribe(1, kSections));
  client->poll_until([&] { return client->state().has_value(); }, kStateWait);
  const View view = view_of(*client);
  if (!options.json) {
    for (const std::string& line : summary_lines(view)) std::printf("%s\n", line.c_str());
    return;
  }
  std::printf(
      "{\"server\":\"%s\",\"server_version\":\"%s\",\"scene\":\"%s\",\"rate_hz\":%g,"
      "\"lease\":%s,\"state\":%s}\n",
      view.server.c_str(), view.scene.server_version().c_str(), view.scene.scene().name().c_str(),
      view.scene.rate_hz(), to_json(view.lease).c_str(),
      view.has_state ? to_json(view.state).c_str() : "null");
}

void watch(const GlobalOptions& options) {
  if (isatty(STDOUT_FILENO) == 0) {
    throw Failure(kUsageBad, "watch draws on a terminal; use status --json in scripts");
  }
  std::deque<v1::Tone> tones;
  TickHistogram ticks;
  client::ClientHandlers handlers;
  handlers.item = [&](const v1::Item& item) {
    if (!item.has_tone()) return;
    tones.push_front(item.tone());
    if (tones.size() > kTonesShown) tones.pop_back();
  };
  handlers.state = [&](const v1::State& state) {
    if (state.has_timing()) ticks.add(state.timing().last_ns());
  };
  const auto client = connect(options, handlers);
  const double rate = client->scene()->rate_hz();
  const auto divisor = static_cast<std::uint32_t>(std::max(1.0, rate / kWatchRate));
  require(client->subscribe(divisor, kSections));
  std::signal(SIGINT, end_watch);
  std::signal(SIGTERM, end_watch);
  const Terminal terminal;
  std::int64_t drawn_ns = 0;
  while (!over.load() && Terminal::key() != 'q') {
    client->poll();
    const std::int64_t now_ns = client::monotonic_now_ns();
    if (1e-9 * static_cast<double>(now_ns - drawn_ns) < kRedraw) continue;
    drawn_ns = now_ns;
    View view = view_of(*client);
    view.ticks = ticks;
    view.tones = tones;
    const winsize size = Terminal::size();
    Terminal::draw(screen_lines(view, size.ws_col, size.ws_row));
  }
}

}  // namespace

void add_status_command(CLI::App& app, const GlobalOptions& options) {
  app.add_subcommand("status", "What the daemon does: state, force, times of the loop")
      ->callback([&options] { status(options); });
}

void add_watch_command(CLI::App& app, const GlobalOptions& options) {
  app.add_subcommand("watch", "The same live, with contacts, strings and tones; q quits")
      ->callback([&options] { watch(options); });
}

}  // namespace hapticd::ctl
