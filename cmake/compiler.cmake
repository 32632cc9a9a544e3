# Two interface targets: what every object of the build is compiled with, and warnings for our own files.
# GCC, Clang, AppleClang and MSVC (also clang-cl).

add_library(rollerrig_code_generation INTERFACE)
add_library(rollerrig_warnings INTERFACE)

if(MSVC)
  # UTF-8 sources; the C++ and preprocessor rules of the standard; objects with more sections than the old format counts.
  # /fp:precise: no NaN or infinity is assumed away, by them a diverging run is noticed.
  target_compile_options(rollerrig_code_generation INTERFACE
    /utf-8 /EHsc /permissive- /Zc:__cplusplus /Zc:preprocessor /bigobj /fp:precise)
  target_compile_definitions(rollerrig_code_generation INTERFACE NOMINMAX _USE_MATH_DEFINES)
  target_compile_options(rollerrig_warnings INTERFACE /W3)
  if(ROLLERRIG_WERROR)
    target_compile_options(rollerrig_warnings INTERFACE /WX)
  endif()
elseif(CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
  # No -ffast-math: NaN and infinity are how a diverging run is noticed.  The two flags below only
  # drop errno and floating-point traps, which nothing here reads; results are unchanged.
  target_compile_options(rollerrig_code_generation INTERFACE -fno-math-errno -fno-trapping-math)
  target_compile_options(rollerrig_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow)
  # GCC 12 trips over its own vector intrinsics (`__m256d __Y = __Y;`) wherever Eigen uses them.
  target_compile_options(rollerrig_warnings INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)

  # Public to every target: Eigen's alignment follows the instruction set, so one object compiled
  # with another -march than its neighbours would disagree about the layout of fixed-size arrays.
  if(ROLLERRIG_NATIVE)
    include(CheckCXXCompilerFlag)
    check_cxx_compiler_flag(-march=native ROLLERRIG_HAS_MARCH_NATIVE)
    if(ROLLERRIG_HAS_MARCH_NATIVE)
      target_compile_options(rollerrig_code_generation INTERFACE -march=native)
    endif()
  endif()

  if(ROLLERRIG_SANITIZE)
    target_compile_options(rollerrig_code_generation INTERFACE
      # Eigen's blocked LU binds a reference to the first element of an empty block (null). What else is left out takes a
      # quarter of the time to compile; the address sanitizer catches every such access, the processor a misaligned one.
      -fsanitize=address,undefined -fno-sanitize=null,alignment,object-size,pointer-overflow
      -fno-sanitize-recover=all -fno-omit-frame-pointer -g1)
    target_link_options(rollerrig_code_generation INTERFACE -fsanitize=address,undefined)
  endif()

  if(ROLLERRIG_FUZZ)  # what it covers is what guides the fuzzer
    target_compile_options(rollerrig_code_generation INTERFACE -fsanitize=fuzzer-no-link)
  endif()

  if(ROLLERRIG_WERROR)
    target_compile_options(rollerrig_warnings INTERFACE -Werror)
  endif()
endif()
