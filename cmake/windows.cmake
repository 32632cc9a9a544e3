# Toolchain: a Linux machine compiles for Windows, with mingw-w64 (Debian's g++-mingw-w64-x86-64-posix).
#
#   cmake -S . -B build/windows -DCMAKE_TOOLCHAIN_FILE=cmake/windows.cmake -DROLLERRIG_NATIVE=OFF

set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
find_program(CMAKE_CXX_COMPILER NAMES x86_64-w64-mingw32-g++-posix x86_64-w64-mingw32-g++ REQUIRED)
find_program(CMAKE_RC_COMPILER NAMES x86_64-w64-mingw32-windres)
