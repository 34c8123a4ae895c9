// See terminal.h.
#include "clients/ctl/terminal.h"

#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>

namespace hapticd::ctl {
namespace {

void write_all(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stdout);
  std::fflush(stdout);
}

}  // namespace

Terminal::Terminal() {
  if (tcgetattr(STDIN_FILENO, &before_) == 0) {
    termios raw = before_;
    raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    changed_ = tcsetattr(STDIN_FILENO, TCSANOW, &raw) == 0;
  }
  write_all("\x1b[?1049h\x1b[?25l");
}

Terminal::~Terminal() {
  write_all("\x1b[?25h\x1b[?1049l");
  if (changed_) tcsetattr(STDIN_FILENO, TCSANOW, &before_);
}

TerminalSize Terminal::size() {
  winsize size{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return {};
  return {size.ws_col, size.ws_row};
}

char Terminal::key() {
  pollfd wanted{STDIN_FILENO, POLLIN, 0};
  char pressed = 0;
  if (::poll(&wanted, 1, 0) <= 0 || ::read(STDIN_FILENO, &pressed, 1) != 1) return 0;
  return pressed;
}

void Terminal::draw(const std::vector<std::string>& lines) {
  std::string text = "\x1b[H";
  for (std::size_t i = 0; i < lines.size(); ++i) {
    text += lines[i] + "\x1b[K" + (i + 1 < lines.size() ? "\r\n" : "");
  }
  write_all(text + "\x1b[J");
}

}  // namespace hapticd::ctl
