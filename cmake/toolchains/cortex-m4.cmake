set(CMAKE_SYSTEM_PROCESSOR arm)
set(tools arm-none-eabi)
set(cpu "-mcpu=cortex-m4 -mthumb") # floating point in software: right with and without an FPU
set(libc "--specs=nano.specs")
include(${CMAKE_CURRENT_LIST_DIR}/bare-metal.cmake)
