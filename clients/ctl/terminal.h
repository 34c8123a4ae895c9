// The terminal of a live view: its second screen, keys as they are pressed. Not RT.
#pragma once

#include <termios.h>

#include <cstddef>
#include <string>
#include <vector>

namespace hapticd::ctl {

/// How often a live view is drawn, s.
inline constexpr double kRedraw = 0.1;

struct TerminalSize {
  std::size_t columns = 80;
  std::size_t rows = 24;
};

/// Without echo and line mode, on its second screen; put back at the end.
class Terminal {
 public:
  Terminal();
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  /// As it is now.
  [[nodiscard]] static TerminalSize size();
  /// A key that was pressed; 0: none.
  [[nodiscard]] static char key();
  /// Instead of what is there.
  static void draw(const std::vector<std::string>& lines);

 private:
  termios before_{};
  bool changed_ = false;
};

}  // namespace hapticd::ctl
