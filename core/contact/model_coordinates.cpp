// See model_coordinates.h. RT: yes.
#include "core/contact/model_coordinates.h"

namespace hapticd {
namespace {

/// A string that is eliminated: its own motion, and with what the core does to it.
void add_eliminated(const StringTerm& term, const LocalModel& model, QpProblem& problem) noexcept {
  const SquareMatrix& basis = model.basis;
  const std::size_t first = term.unknown;
  const EliminatedString& string = model.eliminated()[(first - basis.size) / 2];
  for (std::size_t b = 0; b < 2; ++b) {
    problem.row[first + b][term.row] =
        string.root[0][b] * term.radial + string.root[1][b] * term.tangential;
  }
  std::array<double, kMaxCoreUnknowns> follow;
  for (std::size_t j = 0; j < basis.size; ++j) {
    follow[j] = string.follow[0][j] * term.radial + string.follow[1][j] * term.tangential;
  }
  for (std::size_t k = 0; k < basis.size; ++k) {
    double sum = problem.row[k][term.row];
    for (std::size_t j = 0; j < basis.size; ++j) sum += basis(j, k) * follow[j];
    problem.row[k][term.row] = sum;
  }
}

}  // namespace

void add_string(const StringTerm& term, const LocalModel& model, QpProblem& problem) noexcept {
  const SquareMatrix& basis = model.basis;
  if (term.unknown >= basis.size) {
    add_eliminated(term, model, problem);
    return;
  }
  for (std::size_t k = 0; k < basis.size; ++k) {
    problem.row[k][term.row] +=
        basis(term.unknown, k) * term.radial + basis(term.unknown + 1, k) * term.tangential;
  }
}

void set_objective(const LocalModel& model, QpProblem& problem) noexcept {
  problem.unknowns = static_cast<int>(model.unknowns);
  for (std::size_t k = 0; k < model.unknowns; ++k) {
    problem.weight[k] = 1.0;
    problem.target[k] = model.target_z[k];
  }
}

void find_unknowns(const QpSolution& solution, const LocalModel& model,
                   std::array<double, kMaxQpUnknowns>& y) noexcept {
  const SquareMatrix& basis = model.basis;
  for (std::size_t i = 0; i < basis.size; ++i) {
    double sum = 0.0;
    for (std::size_t k = 0; k < basis.size; ++k) sum += basis(i, k) * solution.x[k];
    y[i] = sum;
  }
  const std::span<const EliminatedString> strings = model.eliminated();
  for (std::size_t s = 0; s < strings.size(); ++s) {
    const std::size_t first = basis.size + 2 * s;
    for (std::size_t a = 0; a < 2; ++a) {
      double sum =
          strings[s].root[a][0] * solution.x[first] + strings[s].root[a][1] * solution.x[first + 1];
      for (std::size_t j = 0; j < basis.size; ++j) sum += strings[s].follow[a][j] * y[j];
      y[first + a] = sum;
    }
  }
}

}  // namespace hapticd
