# Eigen 3.4 from the PyPI package cmeel-eigen where it is installed, else from the system.
# The package lies in <site-packages>/cmeel.prefix; an isolated build has several such folders on sys.path.

find_package(Python 3.11 COMPONENTS Interpreter)
if(Python_Interpreter_FOUND)
  execute_process(
    COMMAND ${Python_EXECUTABLE} -c
      "import pathlib, sys; print(*(p.as_posix() for e in sys.path if (p := pathlib.Path(e, 'cmeel.prefix')).is_dir()), sep=';')"
    OUTPUT_VARIABLE cmeel_prefixes OUTPUT_STRIP_TRAILING_WHITESPACE)
  list(APPEND CMAKE_PREFIX_PATH ${cmeel_prefixes})
endif()

find_package(Eigen3 3.4 QUIET NO_MODULE)
if(NOT Eigen3_FOUND)
  message(FATAL_ERROR "Eigen 3.4 was not found: `pip install cmeel-eigen` into this Python "
                      "(${Python_EXECUTABLE}), or install Debian's libeigen3-dev.")
endif()
