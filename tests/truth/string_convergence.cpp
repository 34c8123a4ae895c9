// Prints, as Markdown, how far the grid of grid_string.h is from its limit and from closed forms:
// the page tests/results/string_truth.md.
//
// usage: string_convergence >tests/results/string_truth.md
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "tests/truth/grid_string.h"
#include "tests/truth/played_string.h"

namespace {

using namespace hapticd;

constexpr std::array kSpeeds{0.45, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.5};
constexpr std::array kCells{275, 550, 1100, 2200};
constexpr int kFinest = 4400;

GridString lossless(double frequency) {
  GridString string;
  string.frequency = frequency;
  string.loss = 0.0;
  string.loss_n2 = 0.0;
  return string;
}

std::vector<GridTone> plucks(int cells) {
  std::vector<GridTone> tones;
  for (const double frequency : {65.4, 146.8}) {
    for (const double lambda : {0.1, 0.25, 0.5}) {
      for (const double speed : kSpeeds) {
        tones.push_back(pluck(lossless(frequency),
                              {.lambda = lambda, .speed = speed, .height = 3e-3, .finger = {}},
                              cells));
      }
    }
  }
  return tones;
}

void print_plucks() {
  std::puts(
      "## Plucks\n\n"
      "54 plucks: strings of 65.4 and 146.8 Hz, 1.1 m, 30 N; at 0.1, 0.25 and 0.5 of the length; "
      "0.45\n"
      "to 1.5 m/s; a finger of 1 kN/m, 5.34 mm with the string, 3 mm above its axis. Level of mode "
      "1\n"
      "and energy of what rings, against 4400 cells.\n\n"
      "| cells | worst dB | rms dB | energy worst dB | rms dB |\n|---:|---:|---:|---:|---:|");
  const std::vector<GridTone> best = plucks(kFinest);
  for (const int cells : kCells) {
    const std::vector<GridTone> tones = plucks(cells);
    std::array<double, 2> worst{0.0, 0.0};
    std::array<double, 2> sum{0.0, 0.0};
    for (std::size_t i = 0; i < best.size(); ++i) {
      const std::array off{20.0 * std::log10(tones[i].amplitude / best[i].amplitude),
                           10.0 * std::log10(tones[i].energy / best[i].energy)};
      for (std::size_t k = 0; k < off.size(); ++k) {
        worst[k] = std::max(worst[k], std::abs(off[k]));
        sum[k] += off[k] * off[k] / static_cast<double>(best.size());
      }
    }
    std::printf("| %d | %.3f | %.3f | %.3f | %.3f |\n", cells, worst[0], std::sqrt(sum[0]),
                worst[1], std::sqrt(sum[1]));
  }
  std::puts("\nMode 1 at its belly, mm, 4400 cells:\n");
  std::printf("| m/s |");
  for (const double speed : kSpeeds) std::printf(" %.2f |", speed);
  std::printf("\n|---|");
  for (std::size_t i = 0; i < kSpeeds.size(); ++i) std::printf("---:|");
  for (std::size_t i = 0; i < best.size(); ++i) {
    if (i % kSpeeds.size() == 0) {
      const std::size_t row = i / kSpeeds.size();
      std::printf("\n| %s Hz at %s |", row < 3 ? "65.4" : "146.8",
                  std::array{"0.1", "0.25", "0.5"}[row % 3]);
    }
    std::printf(" %.3f |", 1e3 * best[i].amplitude);
  }
  std::puts("\n");
}

void print_partials() {
  std::puts(
      "## Partials\n\nCents off the closed form of a string of 65.4 Hz and B = 1e-4, by the phase "
      "of 0.5 s.\n\n"
      "| cells | n = 1 | 4 | 9 | 16 |\n|---:|---:|---:|---:|---:|");
  for (const int cells : {275, 550, 1100}) {
    std::printf("| %d |", cells);
    for (const int n : {1, 4, 9, 16}) {
      GridString string = lossless(65.4);
      string.inharmonicity = 1e-4;
      StringGrid grid(string, cells);
      std::vector<Across> shape;
      for (int j = 0; j <= cells; ++j) {
        shape.emplace_back(1e-3 * std::sin(n * std::numbers::pi * j / cells), 0.0);
      }
      grid.let_go(shape);
      std::vector<double> swing;
      play(grid, {}, 0.5, [&] { swing.push_back(grid.displacement(0.5 / n).x()); });
      const double f = n * 65.4 * std::sqrt((1.0 + 1e-4 * n * n) / (1.0 + 1e-4));
      std::printf(" %.3f |", 1200.0 * std::log2(frequency(swing, grid.step_s(), f) / f));
    }
    std::puts("");
  }
  std::puts("");
}

void print_press() {
  std::puts(
      "## Held still\n\nForce of a finger of 1 kN/m that holds the string by 1 to 20 mm, off "
      "statics, %, worst.\n\n"
      "| cells | at 0.1 | 0.3 | 0.5 |\n|---:|---:|---:|---:|");
  for (const int cells : {275, 550, 1100}) {
    std::printf("| %d |", cells);
    for (const double lambda : {0.1, 0.3, 0.5}) {
      double worst = 0.0;
      for (const double depth : {1e-3, 5e-3, 20e-3}) {
        GridString string = lossless(65.4);
        string.loss = 100.0;
        string.axial_stiffness = 2e3;
        StringGrid grid(string, cells);
        grid.add(GridFinger{});
        const FingerPath path = [&](double time) {
          return FingerPlace{lambda,
                             {0.0, GridFinger{}.radius - depth * std::min(1.0, time / 0.05)}};
        };
        play(grid, {&path, 1}, 0.3);
        const double truth = held_force(string, lambda, grid.displacement(lambda).norm());
        worst = std::max(worst, std::abs(grid.finger(0).normal / truth - 1.0));
      }
      std::printf(" %.3f |", 100.0 * worst);
    }
    std::puts("");
  }
  std::puts("");
}

void print_stops() {
  std::puts(
      "## Stops and harmonics\n\nA string of 0.648 m, 70 N, 110 Hz; a finger of 20 kN/m 0.474 m "
      "from the end that sounds, a fret\n"
      "3 mm below at 0.424 m. Cents off what the part up to the fret, or the finger, sounds at "
      "the\n"
      "tension it then has.\n\n"
      "| E A N | cells | fret Hz | cents | fret N | finger N | without Hz | cents |\n"
      "|---:|---:|---:|---:|---:|---:|---:|---:|");
  for (const double axial_stiffness : {0.0, 5e3}) {
    for (const int cells : {324, 648}) {
      GridString string;
      string.length = 0.648;
      string.tension = 70.0;
      string.frequency = 110.0;
      string.axial_stiffness = axial_stiffness;
      GridFret fret;
      const GridStop on = stop_at_fret(string, fret, cells);
      fret.below = std::numeric_limits<double>::infinity();
      const GridStop off = stop_at_fret(string, fret, cells);
      const auto cents = [&](const GridStop& stop, double part) {
        return 1200.0 *
               std::log2(stop.frequency / (110.0 * 0.648 / part) / std::sqrt(stop.tension / 70.0));
      };
      std::printf("| %g | %d | %.2f | %.2f | %.2f | %.2f | %.2f | %.2f |\n", axial_stiffness, cells,
                  on.frequency, cents(on, 0.424), on.fret_force, on.finger_force, off.frequency,
                  cents(off, 0.474));
    }
  }
  std::puts(
      "\nTouched at a node by a skin of 1 mm, plucked at 0.93, lifted 0.12 s after. The loudest "
      "partial\n"
      "that is none of the harmonic's, dB below it.\n\n"
      "| touch mN | cells | 1/2 Hz | dB | 1/3 Hz | dB | 1/4 Hz | dB | 1/5 Hz | dB |\n"
      "|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
  for (const double force : {8e-3, 25e-3}) {
    for (const int cells : {440, 880}) {
      std::printf("| %g | %d |", 1e3 * force, cells);
      for (const int part : {2, 3, 4, 5}) {
        GridHarmonic harmonic;
        harmonic.part = part;
        harmonic.force = force;
        const GridPartials partials = touch_harmonic(GridString{}, harmonic, cells);
        std::printf(" %.2f | %.1f |", partials.frequency, partials.others);
      }
      std::puts("");
    }
  }
}

}  // namespace

int main() {
  std::puts(
      "# The truth about played strings, and how true it is\n\n"
      "Written by `string_convergence` of tests/truth: finite differences of a string that fingers "
      "and frets\n"
      "touch (`tests/truth/grid_string.h`), by which strings that sound are judged. It shares "
      "neither code\n"
      "nor method with them. The numbers are the same on every machine.\n");
  print_plucks();
  print_partials();
  print_press();
  print_stops();
  return 0;
}
