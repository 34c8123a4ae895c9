// Rows of a table of poses. Pure. Not RT.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "hapticd/v1/pose.pb.h"

namespace hapticd::ctl {

/// Where a row stands.
struct RowPlace {
  std::string file;  ///< empty: stdin
  int line = 0;      ///< from 1
};

/// A line "x, y, z" or "x, y, z, qw, qx, qy, qz", separated by commas or blanks: metres, or lengths
/// with their unit. Nothing for an empty line, a comment (#) or the heading: a first line of
/// several words that begins with a letter. Throws Failure(kRefused) that names the line: it is
/// anything else, a number is not finite, or the norm of the quaternion is outside [0.5, 2]
/// (PROTOCOL.md, section 9).
[[nodiscard]] std::optional<v1::Pose> parse_pose(std::string_view line, const RowPlace& place);

}  // namespace hapticd::ctl
