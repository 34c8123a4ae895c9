// The ranges that scene.proto states in the comments of its fields. Not RT.
#pragma once

#include <limits>
#include <map>
#include <string>

namespace hapticd::test {

/// An interval as a comment writes it, such as "(0, 100]".
struct ProtoRange {
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
  bool low_included = false;
  bool high_included = false;
  std::string text;
};

/// "Message.field" -> range, for every field of scene.proto whose comment has one. Throws
/// std::runtime_error when the file is missing.
std::map<std::string, ProtoRange> proto_ranges();

}  // namespace hapticd::test
