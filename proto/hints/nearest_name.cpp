// See nearest_name.h.
#include "proto/hints/nearest_name.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace hapticd::hints {
namespace {

constexpr std::size_t kMaxLength = 64;
/// Shorter beginnings are those of too many names.
constexpr std::size_t kMinBeginning = 3;

/// ASCII alone: names have no other letters.
char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool same(char a, char b) { return lower(a) == lower(b); }

/// Edits from `a` to `b`, both of at most kMaxLength: the optimal string alignment distance.
std::size_t distance(std::string_view a, std::string_view b) {
  using Row = std::array<std::size_t, kMaxLength + 1>;
  Row before{};
  Row last{};
  Row row{};
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      row[j + 1] = std::min({last[j] + (same(a[i], b[j]) ? 0U : 1U), last[j + 1] + 1, row[j] + 1});
      const bool exchanged = i > 0 && j > 0 && same(a[i], b[j - 1]) && same(a[i - 1], b[j]);
      if (exchanged) row[j + 1] = std::min(row[j + 1], before[j - 1] + 1);
    }
    before = last;
    last = row;
  }
  return last[b.size()];
}

bool begins(std::string_view name, std::string_view with) {
  return with.size() >= kMinBeginning && name.size() > with.size() &&
         std::equal(with.begin(), with.end(), name.begin(), same);
}

}  // namespace

std::string nearest_name(std::string_view name, std::span<const std::string> names) {
  std::string nearest;
  if (name.empty() || name.size() > kMaxLength) return nearest;
  std::size_t best = std::max<std::size_t>(1, name.size() / 3) + 1;
  for (const std::string& candidate : names) {
    if (candidate.size() > kMaxLength) continue;
    std::size_t edits = distance(name, candidate);
    if (begins(candidate, name)) edits = std::min<std::size_t>(edits, 1);
    if (edits >= best) continue;
    best = edits;
    nearest = candidate;
  }
  return nearest;
}

std::string did_you_mean(std::string_view name, std::span<const std::string> names) {
  const std::string nearest = nearest_name(name, names);
  return nearest.empty() ? "" : " Did you mean " + nearest + "?";
}

}  // namespace hapticd::hints
