// Files of secrets: readable by their owner alone, written whole or not at all. Not RT.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace hapticd::noise {

/// Throws std::runtime_error with the file and `what`, a sentence with the remedy.
[[noreturn]] void refuse_file(const std::filesystem::path& file, const std::string& what);

/// Reads the first bytes of `file` into `into`; its size, bytes, which may be another than that of
/// `into`. Throws std::runtime_error with the file and the remedy: it cannot be read, is no file,
/// or users other than its owner may access it.
[[nodiscard]] std::size_t read_private_file(const std::filesystem::path& file,
                                            std::span<std::uint8_t> into);

/// Writes a new file of mode 0600. Throws std::runtime_error with the file and the remedy: it is
/// there, or cannot be written.
void write_private_file(const std::filesystem::path& file, std::span<const std::uint8_t> bytes);

/// The same in place of a file that is there, which stays as it was until all is written.
void replace_private_file(const std::filesystem::path& file, std::span<const std::uint8_t> bytes);

/// Makes a folder of mode 0700, and those above it, if it is not there. Throws std::runtime_error
/// with the remedy.
void make_private_folder(const std::filesystem::path& folder);

}  // namespace hapticd::noise
