// integrate/rodas4_tableau.hpp - the numbers of RODAS, set METH = 1 of Hairer and Wanner's code.
//
// They hold in the variables u of HW II, IV.7 (7.25).  A test proves with them, to round-off, the order
// conditions of order 4 (also those of index-1 algebraic equations: no order is lost in the stiff limit),
// of the embedded solution and of the dense output (order 3 each).  Indices start at 0.
// Source  Hairer, Wanner, Solving ODEs II (1996), VI.4 (4.15)-(4.22) and their code RODAS of 28 October 1996.
#pragma once

namespace rollerrig::integrate::rodas4_tableau {

inline constexpr int stages = 6;

/// Diagonal of the method: 1/(h gamma) is the shift of every linear solve.
inline constexpr double gamma = 0.25;

/// Times of the stages, in steps.
inline constexpr double alpha[stages] = {0, 0.386, 0.21, 0.63, 1, 1};

/// Weight of h df/dt in each stage.
inline constexpr double time_weight[stages] = {0.25, -0.1043, 0.1035, -0.03620000000000023, 0, 0};

/// Argument of stage i: y + sum_j a[i][j] u_j.  Row 5, the embedded solution, is row 4 plus u_4.
inline constexpr double a[stages][5] = {
    {},
    {1.544},
    {0.9466785280815826, 0.2557011698983284},
    {3.314825187068521, 2.896124015972201, 0.9986419139977817},
    {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950},
    {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 1},
};

/// Right-hand side of stage i: + sum_j c[i][j] u_j / h.
inline constexpr double c[stages][5] = {
    {},
    {-5.6688},
    {-2.430093356833875, -0.2063599157091915},
    {-0.1073529058151375, -9.594562251023355, -20.47028614809616},
    {7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160},
    {8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054},
};

/// Dense output: y (1-s) + s (y_new + (1-s) (sum_j bend[j] u_j + s sum_j cubic[j] u_j)).
inline constexpr double bend[5] = {10.12623508344586, -7.487995877610167, -34.80091861555747, -7.992771707568823,
                                   1.025137723295662};
inline constexpr double cubic[5] = {-0.6762803392801253, 6.087714651680015, 16.43084320892478, 24.76722511418386,
                                    -6.594389125716872};

}  // namespace rollerrig::integrate::rodas4_tableau
