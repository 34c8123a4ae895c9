// Small text files that hapticd keeps of devices, read, and written so that they outlast a loss of
// power. Not RT.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace hapticd {

/// Small letters and digits.
[[nodiscard]] std::string hex(std::span<const std::uint8_t> bytes);

/// Fit for a file's name, and for text in quotes.
[[nodiscard]] std::string plain(std::string_view text);

/// A line by which a record that was changed is known: a hash of `text`.
[[nodiscard]] std::string seal_of(std::string_view text);

/// Something of that name is there.
[[nodiscard]] bool is_there(const std::filesystem::path& file);

/// The start of the file in `text`; returns why it cannot be read, empty: it can.
[[nodiscard]] std::string read_record(const std::filesystem::path& file, std::string& text);

/// Puts `text` in the place of what was there, or leaves that as it was. Makes the folder. Throws
/// std::runtime_error with file, reason and remedy.
void write_record(const std::filesystem::path& file, const std::string& text);

/// Takes the file away if it is there; throws likewise.
void remove_record(const std::filesystem::path& file);

}  // namespace hapticd
