#include "rollerrig/contact/normal/strip_problem.hpp"

#include "rollerrig/contact/normal/strip_contact.hpp"

namespace rollerrig {
namespace {

constexpr int per_region = Strips<double>::per_region;
constexpr int capacity = Strips<double>::capacity;
constexpr double smallest_length = 0.02;  // of the half-length over the strip's width: keeps the logarithm of a finite
using Row = std::array<double, capacity>;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// The kernel's two integrals, and what they lose on a point that is not beside the strip's middle but `ahead` of it: far
/// away a point load's field, near by the second order of the distance (both in half-lengths).
struct Deflection {
  StripKernel const& kernel;
  template <Scalar T>
  T operator()(T const& k) const {
    return kernel.deflection(k);
  }
  template <Scalar T>
  static T ahead(T const& beside2, T const& ahead2) {
    using std::sqrt;
    return sqrt(beside2 / (beside2 + ahead2));
  }
};
struct Curvature {
  StripKernel const& kernel;
  template <Scalar T>
  T operator()(T const& k) const {
    return kernel.curvature(k);
  }
  template <Scalar T>
  static T ahead(T const& beside2, T const& ahead2) {
    T const nearer = Deflection::ahead(beside2, ahead2);
    T const nearer2 = nearer * nearer;
    return nearer * nearer2 * (nearer2 - 2.0 * ahead2 / (beside2 + ahead2));
  }
};

/// K and S of the strips: influence of strip i on the middle of strip j, from the kernel's integral.
///
/// @param wanted  which strips act and are looked at; others between them may be looked at too
/// @param store   (i, j, value)
template <Scalar T, class Read, class Store>
void influences(Strips<T> const& s, std::array<T, capacity> const& a, std::array<char, capacity> const& wanted,
                Read const& read, Store const& store) {
  std::array<T, per_region> value;
  for (int region = 0; region < s.regions; ++region) {
    int const first = region * per_region;
    int lowest = first, highest = first + per_region - 1;
    while (lowest < highest && !wanted[at(lowest)]) ++lowest;
    while (highest > lowest && !wanted[at(highest)]) --highest;
    for (int i = lowest; i <= highest; ++i) {
      if (!wanted[at(i)]) continue;
      T const inverse = 1.0 / a[at(i)];
      T const h = s.width[at(region)] * inverse;
      // Strips of one region are equally wide: distances of the edges repeat.
      T inner = read(0.5 * h);
      value[0] = inner + inner;
      int const farthest = std::max(i - lowest, highest - i);
      for (int k = 1; k <= farthest; ++k) {
        T const outer = read((k + 0.5) * h);
        value[at(k)] = outer - inner;
        inner = outer;
      }
      for (int j = lowest; j < i; ++j) store(i, j, value[at(i - j)]);
      for (int j = i; j <= highest; ++j) store(i, j, value[at(j - i)]);
      for (int j = 0; j < s.count() && s.regions > 1; ++j) {
        if (!wanted[at(j)] || j / per_region == region) continue;
        T distance = (s.position[at(j)] - s.position[at(i)]) * inverse;
        if (distance < 0.0) distance = -distance;
        T const ahead = (s.offset[at(j)] - s.offset[at(i)]) * inverse;
        store(i, j,
              (read(distance + 0.5 * h) - read(distance - 0.5 * h)) *
                  Read::ahead(1.0 + distance * distance, ahead * ahead));
      }
    }
  }
}

/// Dense system of the loaded strips, factorised without pivoting: influence falls with distance.
class LoadedStrips {
 public:
  /// @param k  k[i][j]: influence of strip i on strip j, the transposed system
  void factorise(std::array<Row, capacity> const& k, std::array<char, capacity> const& loaded, int n) {
    count_ = 0;
    for (int i = 0; i < n; ++i)
      if (loaded[at(i)]) index_[at(count_++)] = i;
    for (int r = 0; r < count_; ++r)
      for (int c = 0; c < count_; ++c) lu_[at(r)][at(c)] = k[at(index_[at(r)])][at(index_[at(c)])];
    for (int p = 0; p < count_; ++p) {
      double const inverse = 1.0 / lu_[at(p)][at(p)];
      inverse_pivot_[at(p)] = inverse;
      for (int r = p + 1; r < count_; ++r) {
        double const factor = lu_[at(r)][at(p)] * inverse;
        lu_[at(r)][at(p)] = factor;
        for (int c = p + 1; c < count_; ++c) lu_[at(r)][at(c)] -= factor * lu_[at(p)][at(c)];
      }
    }
  }
  /// Solves for the loaded strips; the others of x are left alone. The factors are those of the transposed matrix.
  void solve(Row& x) const {
    Row y;
    for (int r = 0; r < count_; ++r) y[at(r)] = x[at(index_[at(r)])];
    for (int r = 0; r < count_; ++r) {
      double const known = y[at(r)] *= inverse_pivot_[at(r)];
      for (int c = r + 1; c < count_; ++c) y[at(c)] -= lu_[at(r)][at(c)] * known;
    }
    for (int r = count_ - 1; r >= 0; --r) {
      double const known = y[at(r)];
      for (int c = 0; c < r; ++c) y[at(c)] -= lu_[at(r)][at(c)] * known;
      x[at(index_[at(r)])] = known;
    }
  }

 private:
  int count_{0};
  std::array<int, capacity> index_;
  std::array<Row, capacity> lu_;
  Row inverse_pivot_;
};

/// w >= 0 and deflection = d where w > 0 (S3): the loaded strips are found by switching those that violate it.
template <Scalar T>
void solve_load(StripKernel const& kernel, double compliance, Strips<T>& s, std::array<T, capacity> const& a,
                std::array<char, capacity>& loaded) {
  int const n = s.count();
  std::array<double, capacity> a_value;
  Strips<double> plain;  // only what influences() reads
  plain.regions = s.regions;
  std::array<char, capacity> all{};
  for (int i = 0; i < n; ++i) {
    all[at(i)] = value_of(s.interpenetration[at(i)]) > 0.0;
    a_value[at(i)] = value_of(a[at(i)]);
    plain.position[at(i)] = value_of(s.position[at(i)]);
    plain.offset[at(i)] = value_of(s.offset[at(i)]);
  }
  for (int k = 0; k < s.regions; ++k) plain.width[at(k)] = value_of(s.width[at(k)]);
  std::array<Row, capacity> matrix;
  influences(plain, a_value, all, Deflection{kernel},
             [&](int i, int j, double value) { matrix[at(i)][at(j)] = compliance * value; });

  LoadedStrips system;
  Row w;
  for (int round = 0; round < 30; ++round) {
    system.factorise(matrix, loaded, n);
    for (int i = 0; i < n; ++i) w[at(i)] = loaded[at(i)] ? value_of(s.interpenetration[at(i)]) : 0.0;
    system.solve(w);
    bool changed = false;
    auto next = loaded;
    for (int j = 0; j < n; ++j) {
      if (loaded[at(j)]) {
        next[at(j)] = w[at(j)] > 0.0;
      } else if (all[at(j)]) {
        double u = 0.0;
        for (int i = 0; i < n; ++i)
          if (loaded[at(i)]) u += matrix[at(i)][at(j)] * w[at(i)];
        next[at(j)] = u < value_of(s.interpenetration[at(j)]);
      }
      changed = changed || next[at(j)] != loaded[at(j)];
    }
    if (!changed) break;
    loaded = next;
  }
  for (int i = 0; i < n; ++i) s.load[at(i)] = T(loaded[at(i)] ? std::max(0.0, w[at(i)]) : 0.0);
  if constexpr (!std::same_as<T, double>) {
    // K dw = dd - dK w, derivative by derivative.
    std::array<T, capacity> residual;
    for (int i = 0; i < n; ++i) residual[at(i)] = s.interpenetration[at(i)];
    influences(s, a, loaded, Deflection{kernel},
               [&](int i, int j, T const& value) { residual[at(j)] -= (compliance * w[at(i)]) * value; });
    for (int seed = 0; seed < residual[0].d.size(); ++seed) {
      Row change{};
      for (int i = 0; i < n; ++i)
        if (loaded[at(i)]) change[at(i)] = residual[at(i)].d[seed];
      system.solve(change);
      for (int i = 0; i < n; ++i)
        if (loaded[at(i)]) s.load[at(i)].d[seed] = change[at(i)];
    }
  }
}

/// The parabola of the region's width and mean depth, pressed after Hertz: conformity q/A and half-lengths to start from.
template <Scalar T>
void start_from_hertz(HertzTable const& hertz, Strips<T>& s, int region, std::array<T, capacity>& q,
                      std::array<char, capacity>& loaded) {
  using std::log;
  using std::sqrt;
  int const first = region * per_region;
  T depth(0.0), along_x(0.0);
  for (int i = first; i < first + per_region; ++i) {
    depth += select(s.interpenetration[at(i)] > 0.0, s.interpenetration[at(i)], T(0.0));
    along_x += s.curvature[at(i)];
  }
  along_x = (1.0 / per_region) * along_x;
  // A parabola's height over its mean, 3/2 where the strips cover it up to its ends.
  T const reach2 = s.reach[at(region)] * s.reach[at(region)];
  T const half_width = (0.5 * per_region) * s.width[at(region)];
  depth = (reach2 / (reach2 - 1.0 / 3.0) / per_region) * depth;
  T const across = depth / (reach2 * half_width * half_width);
  T const ratio = along_x / across;
  double const limit = HertzTable::limit;
  T const x = log(select(ratio < 1.0 / limit, T(1.0 / limit), select(ratio > limit, T(limit), ratio)));
  T const a = hertz.semi_axis.at(x).value;  // a / sqrt(p / (A+B)), (17)
  T const b = hertz.semi_axis.at(-x).value;
  T const sum = along_x + across;
  T const conformity = 1.5 / pi * hertz.stiffness.at(x).value * sum / (a * a * b * along_x);  // Q p0 / (a A)
  T const square_length = a * a / sum;                                                        // a^2 over the depth
  T const floor = square(smallest_length * s.width[at(region)]);
  double const edge = value_of(depth) * (1.0 - value_of(b * b * across / sum));  // interpenetration at Hertz' edge
  for (int i = first; i < first + per_region; ++i) {
    T const d = select(s.interpenetration[at(i)] > 0.0, s.interpenetration[at(i)], T(0.0));
    loaded[at(i)] = value_of(d) > edge;
    s.half_length[at(i)] = sqrt(square_length * d + floor);
    q[at(i)] = conformity * s.curvature[at(i)];
  }
}

/// a from w and q (S4), kept above zero.
template <Scalar T>
void lengths_from_load(double compliance, Strips<T>& s, std::array<T, capacity> const& q) {
  using std::sqrt;
  for (int region = 0; region < s.regions; ++region) {
    T const floor = square(smallest_length * s.width[at(region)]);
    for (int i = region * per_region; i < (region + 1) * per_region; ++i)
      s.half_length[at(i)] = sqrt(2.0 * compliance * s.load[at(i)] / q[at(i)] + floor);
  }
}

/// One update of the conformity along x: q A / (S q) to the power 3/4, which lies between what a line contact and a patch
/// long in x ask for; then a from w and q. (S4), (S5)
template <Scalar T>
void update_lengths(StripKernel const& kernel, double compliance, Strips<T>& s,
                    std::array<char, capacity> const& loaded, std::array<T, capacity>& q) {
  using std::sqrt;
  std::array<T, capacity> sum;
  sum.fill(T(0.0));
  influences(s, s.half_length, loaded, Curvature{kernel},
             [&](int i, int j, T const& value) { sum[at(j)] += 0.25 * q[at(i)] * value; });
  for (int j = 0; j < s.count(); ++j) {
    if (!loaded[at(j)]) continue;
    T const root = sqrt(s.curvature[at(j)] / sum[at(j)]);
    q[at(j)] = q[at(j)] * root * sqrt(root);
  }
  lengths_from_load(compliance, s, q);
}

}  // namespace

template <Scalar T>
void solve_strips(Material const& material, Strips<T>& s) {
  StripKernel const& kernel = strip_kernel();
  HertzTable const& hertz = hertz_table();
  double const compliance = material.compliance() / pi;  // Q/pi
  std::array<T, capacity> q;
  std::array<char, capacity> loaded{};
  for (int region = 0; region < s.regions; ++region) start_from_hertz(hertz, s, region, q, loaded);
  solve_load(kernel, compliance, s, s.half_length, loaded);
  lengths_from_load(compliance, s, q);
  update_lengths(kernel, compliance, s, loaded, q);
  solve_load(kernel, compliance, s, s.half_length, loaded);
  lengths_from_load(compliance, s, q);
  update_lengths(kernel, compliance, s, loaded, q);
}

template void solve_strips(Material const&, Strips<double>&);
template void solve_strips(Material const&, Strips<StripDual>&);

}  // namespace rollerrig
