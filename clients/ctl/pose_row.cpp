// See pose_row.h.
#include "clients/ctl/pose_row.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <system_error>
#include <vector>

#include "clients/ctl/connection.h"
#include "proto/hints/quantity.h"
#include "proto/wire/whole_characters.h"

namespace hapticd::ctl {
namespace {

constexpr std::string_view kSeparators = " \t\r,";
/// Of the norm of a quaternion: PROTOCOL.md, section 9.
constexpr double kLeastNorm = 0.5;
constexpr double kMostNorm = 2.0;
/// Of what is quoted, bytes.
constexpr std::size_t kQuoted = 40;

constexpr const char* kForm =
    " A pose is x, y, z in metres, and qw, qx, qy, qz if it turns; all are finite.";

[[noreturn]] void refuse(const RowPlace& place, const std::string& what) {
  const std::string line = std::to_string(place.line);
  throw Failure(kRefused, (place.file.empty() ? "line " + line : place.file + ":" + line) + ": " +
                              what + kForm);
}

std::string quoted(std::string_view text) {
  const bool fits = text.size() <= kQuoted;
  return "'" + wire::whole_characters(std::string(text), kQuoted) + (fits ? "'" : "...'");
}

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t at = line.find_first_not_of(kSeparators); at != std::string_view::npos;
       at = line.find_first_not_of(kSeparators, at)) {
    const std::size_t end = std::min(line.find_first_of(kSeparators, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

/// Whether it is a number without a unit, one that is not finite included.
bool is_number(std::string_view word) {
  double ignored = 0.0;
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), ignored);
  return error != std::errc::invalid_argument && stop == word.data() + word.size();
}

bool is_heading(const std::vector<std::string_view>& words) {
  return words.size() > 1 && std::isalpha(static_cast<unsigned char>(words[0][0])) != 0 &&
         std::none_of(words.begin(), words.end(), is_number);
}

double number_of(std::string_view word, const char* unit, const RowPlace& place) {
  const hints::Quantity quantity = hints::parse_quantity(word, unit);
  if (!quantity.fault.empty()) refuse(place, quoted(word) + " cannot be read. " + quantity.fault);
  return quantity.value;
}

}  // namespace

std::optional<v1::Pose> parse_pose(std::string_view line, const RowPlace& place) {
  const std::vector<std::string_view> words = words_of(line);
  if (words.empty() || words.front().starts_with('#')) return std::nullopt;
  if (place.line == 1 && is_heading(words)) return std::nullopt;
  if (words.size() != 3 && words.size() != 7) {
    refuse(place, quoted(line) + " is not 3 or 7 numbers.");
  }
  v1::Pose pose;
  for (std::size_t i = 0; i < 3; ++i) pose.add_p_m(number_of(words[i], "m", place));
  std::array<double, 4> q{1.0, 0.0, 0.0, 0.0};
  if (words.size() == 7) {
    for (std::size_t i = 0; i < 4; ++i) q[i] = number_of(words[3 + i], "", place);
  }
  const double norm = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
  if (!(norm >= kLeastNorm && norm <= kMostNorm)) {
    refuse(place, "the norm of qw, qx, qy, qz is outside [0.5, 2].");
  }
  for (const double number : q) pose.add_q(number);
  return pose;
}

}  // namespace hapticd::ctl
