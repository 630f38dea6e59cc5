// hypre's BoomerAMG as preconditioner of conjugate gradients, on a matrix that bench/micro/multigrid.cpp has written.
//
// Usage: [mpirun -np N] boomer_amg FILE [strong threshold = 0.5] [levels of aggressive coarsening = 0] [loads = 1]
// Settings as hypre's manual recommends: HMIS coarsening, extended+i interpolation with at most 4 entries per row, the
// strong threshold 0.25 in the plane and 0.5 in space, one sweep of the default smoother up and down.
#include <HYPRE.h>
#include <HYPRE_IJ_mv.h>
#include <HYPRE_krylov.h>
#include <HYPRE_parcsr_ls.h>
#include <mpi.h>
#include <sys/resource.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <vector>

namespace {

struct Rows {
  std::int64_t n = 0, begin = 0, end = 0;  ///< Of the matrix; those of this rank.
  std::vector<std::uint64_t> offsets;
  std::vector<std::uint32_t> columns;
  std::vector<double> values, load;
};

template <class T>
std::vector<T> read_part(std::ifstream& in, std::uint64_t start, std::uint64_t first, std::uint64_t count) {
  std::vector<T> part(count);
  in.seekg(static_cast<std::streamoff>(start + first * sizeof(T)));
  in.read(reinterpret_cast<char*>(part.data()), static_cast<std::streamsize>(count * sizeof(T)));
  return part;
}

/// The file: n, n_entries, offsets[n + 1], columns, values, load[n].
Rows read_rows(const char* file, int rank, int n_ranks) {
  std::ifstream in(file, std::ios::binary);
  Rows rows;
  const auto head = read_part<std::uint64_t>(in, 0, 0, 2);
  if (!in) std::exit(2);
  const std::uint64_t n = head[0], n_entries = head[1];
  rows.n = static_cast<std::int64_t>(n);
  rows.begin = rows.n * rank / n_ranks;
  rows.end = rows.n * (rank + 1) / n_ranks;
  const auto begin = static_cast<std::uint64_t>(rows.begin), end = static_cast<std::uint64_t>(rows.end);
  std::uint64_t at = 16;
  rows.offsets = read_part<std::uint64_t>(in, at, begin, end - begin + 1);
  const std::uint64_t first = rows.offsets.front(), count = rows.offsets.back() - first;
  rows.columns = read_part<std::uint32_t>(in, at += 8 * (n + 1), first, count);
  rows.values = read_part<double>(in, at += 4 * n_entries, first, count);
  rows.load = read_part<double>(in, at += 8 * n_entries, begin, end - begin);
  return rows;
}

/// Processor seconds of all ranks together.
double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  double mine = seconds(usage.ru_utime) + seconds(usage.ru_stime), all = 0;
  MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  return all;
}

HYPRE_IJMatrix make_matrix(const Rows& rows) {
  HYPRE_IJMatrix matrix = nullptr;
  HYPRE_IJMatrixCreate(MPI_COMM_WORLD, static_cast<HYPRE_BigInt>(rows.begin), static_cast<HYPRE_BigInt>(rows.end - 1),
                       static_cast<HYPRE_BigInt>(rows.begin), static_cast<HYPRE_BigInt>(rows.end - 1), &matrix);
  HYPRE_IJMatrixSetObjectType(matrix, HYPRE_PARCSR);
  HYPRE_IJMatrixInitialize(matrix);
  std::vector<HYPRE_BigInt> columns;
  for (std::int64_t row = rows.begin; row != rows.end; ++row) {
    const auto i = static_cast<std::size_t>(row - rows.begin);
    const std::uint64_t from = rows.offsets[i] - rows.offsets[0];
    auto count = static_cast<HYPRE_Int>(rows.offsets[i + 1] - rows.offsets[i]);
    columns.assign(rows.columns.begin() + static_cast<long>(from),
                   rows.columns.begin() + static_cast<long>(from) + count);
    const auto global = static_cast<HYPRE_BigInt>(row);
    HYPRE_IJMatrixSetValues(matrix, 1, &count, &global, columns.data(), rows.values.data() + from);
  }
  HYPRE_IJMatrixAssemble(matrix);
  return matrix;
}

HYPRE_IJVector make_vector(const Rows& rows, const std::vector<double>& values) {
  HYPRE_IJVector vector = nullptr;
  HYPRE_IJVectorCreate(MPI_COMM_WORLD, static_cast<HYPRE_BigInt>(rows.begin), static_cast<HYPRE_BigInt>(rows.end - 1),
                       &vector);
  HYPRE_IJVectorSetObjectType(vector, HYPRE_PARCSR);
  HYPRE_IJVectorInitialize(vector);
  std::vector<HYPRE_BigInt> indices;
  for (std::int64_t row = rows.begin; row != rows.end; ++row) indices.push_back(static_cast<HYPRE_BigInt>(row));
  HYPRE_IJVectorSetValues(vector, static_cast<HYPRE_Int>(indices.size()), indices.data(), values.data());
  HYPRE_IJVectorAssemble(vector);
  return vector;
}

HYPRE_Solver make_amg(double threshold, int n_aggressive) {
  HYPRE_Solver amg = nullptr;
  HYPRE_BoomerAMGCreate(&amg);
  HYPRE_BoomerAMGSetPrintLevel(amg, 1);    // Levels and complexities.
  HYPRE_BoomerAMGSetCoarsenType(amg, 10);  // HMIS
  HYPRE_BoomerAMGSetInterpType(amg, 6);    // Extended+i
  HYPRE_BoomerAMGSetPMaxElmts(amg, 4);
  HYPRE_BoomerAMGSetStrongThreshold(amg, threshold);
  HYPRE_BoomerAMGSetAggNumLevels(amg, n_aggressive);
  HYPRE_BoomerAMGSetTol(amg, 0);
  HYPRE_BoomerAMGSetMaxIter(amg, 1);
  return amg;
}

struct Clock {
  double wall = MPI_Wtime(), processor = processor_seconds();
};

void print_since(const Clock& begin, const char* what, int rank) {
  const Clock now;
  if (rank == 0)
    std::printf("%s: %.2f s, %.2f s of processor time\n", what, now.wall - begin.wall, now.processor - begin.processor);
}

int run(int argc, char** argv) {
  int rank = 0, n_ranks = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &n_ranks);
  if (argc < 2) return 2;
  const Rows rows = read_rows(argv[1], rank, n_ranks);
  const double threshold = argc > 2 ? std::atof(argv[2]) : 0.5;
  const int n_aggressive = argc > 3 ? std::atoi(argv[3]) : 0, n_loads = argc > 4 ? std::atoi(argv[4]) : 1;

  HYPRE_IJMatrix matrix = make_matrix(rows);
  void* object = nullptr;
  HYPRE_IJMatrixGetObject(matrix, &object);
  auto a = static_cast<HYPRE_ParCSRMatrix>(object);
  HYPRE_Solver pcg = nullptr, amg = make_amg(threshold, n_aggressive);
  HYPRE_ParCSRPCGCreate(MPI_COMM_WORLD, &pcg);
  HYPRE_PCGSetTol(pcg, 1e-8);
  HYPRE_PCGSetTwoNorm(pcg, 1);
  HYPRE_PCGSetMaxIter(pcg, 200);
  HYPRE_PCGSetPrecond(pcg, reinterpret_cast<HYPRE_PtrToSolverFcn>(HYPRE_BoomerAMGSolve),
                      reinterpret_cast<HYPRE_PtrToSolverFcn>(HYPRE_BoomerAMGSetup), amg);
  const Clock before_setup;
  for (int load = 0; load < n_loads; ++load) {
    std::vector<double> values = rows.load;
    // The loads of bench/micro/multigrid.cpp.
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] *= 1 + 0.1 * static_cast<double>((static_cast<std::uint64_t>(rows.begin) + i) %
                                                 (2 + static_cast<std::uint64_t>(load)));
    HYPRE_IJVector b = make_vector(rows, values), x = make_vector(rows, std::vector<double>(values.size()));
    HYPRE_IJVectorGetObject(b, &object);
    auto b_vector = static_cast<HYPRE_ParVector>(object);
    HYPRE_IJVectorGetObject(x, &object);
    auto x_vector = static_cast<HYPRE_ParVector>(object);
    if (load == 0) {
      HYPRE_ParCSRPCGSetup(pcg, a, b_vector, x_vector);
      print_since(before_setup, "setup", rank);
    }
    const Clock before_solve;
    HYPRE_ParCSRPCGSolve(pcg, a, b_vector, x_vector);
    HYPRE_Int iterations = 0;
    HYPRE_PCGGetNumIterations(pcg, &iterations);
    print_since(before_solve, "solve", rank);
    if (load == 0) print_since(before_setup, "setup and first load", rank);
    if (rank == 0) std::printf("iterations %d\n", static_cast<int>(iterations));
    HYPRE_IJVectorDestroy(b);
    HYPRE_IJVectorDestroy(x);
  }
  print_since(before_setup, "setup and all loads", rank);
  HYPRE_ParCSRPCGDestroy(pcg);
  HYPRE_BoomerAMGDestroy(amg);
  HYPRE_IJMatrixDestroy(matrix);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  HYPRE_Init();
  const int code = run(argc, argv);
  HYPRE_Finalize();
  MPI_Finalize();
  return code;
}
