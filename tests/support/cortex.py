"""Programs for a Cortex-M4F and a Cortex-M7 without a system, built and run under QEMU."""

import shutil
import subprocess
from pathlib import Path

TOOLS = ("arm-none-eabi-gcc", "arm-none-eabi-size", "qemu-system-arm")
BOARDS = {
    "cortex-m4": ("mps2-an386", "-mcpu=cortex-m4 -mfpu=fpv4-sp-d16"),
    "cortex-m7": ("mps2-an500", "-mcpu=cortex-m7 -mfpu=fpv5-d16"),
}
FLAGS = "-mthumb -mfloat-abi=hard -ffp-contract=off -ffunction-sections -fdata-sections"
# Vectors, the FPU switched on, data and bss; results leave by semihosting.
START = """
#include <stdint.h>
extern uint32_t stack_top, bss_start, bss_end;
int run(void);
static int host(int op, const void *argument) {
    register int r0 __asm__("r0") = op;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}
void say(const char *text) { host(4, text); }
static void leave(int status) {
    uint32_t block[2] = {0x20026, 0};
    block[1] = (uint32_t)status;
    host(0x20, block);
    for (;;) { }
}
__attribute__((optimize("no-tree-loop-distribute-patterns"))) void reset(void) {
    uint32_t *p;
    *(volatile uint32_t *)0xE000ED88 |= 0xF00000u;
    __asm__ volatile("dsb\\nisb");
    for (p = &bss_start; p < &bss_end; ++p) *p = 0;
    leave(run());
}
static void fault(void) { leave(99); }
__attribute__((section(".vectors"), used)) static const void *vectors[16] = {
    &stack_top, (const void *)reset, (const void *)fault, (const void *)fault, (const void *)fault,
    (const void *)fault, (const void *)fault};
"""
# How much of the stack some work takes: painted before, and looked at after.
DEPTH = """
#include <stdint.h>
__attribute__((noinline)) static uint32_t depth(void (*work)(void)) {
    volatile unsigned char here[16], *const top = here, *p;
    here[0] = 0;
    for (p = top - 16384; p < top - 64; ++p) *p = 0xA5;
    work();
    for (p = top - 16384; *p == 0xA5; ++p) { }
    return (uint32_t)(top - p);
}
"""
LAYOUT = """
MEMORY { rom : ORIGIN = 0, LENGTH = 4M
         ram : ORIGIN = 0x20000000, LENGTH = 4M }
SECTIONS {
  .text : { KEEP(*(.vectors)) *(.text*) *(.rodata*) } > rom
  .ARM.exidx : { *(.ARM.exidx*) } > rom
  .data : { *(.data*) } > ram
  .bss : { bss_start = .; *(.bss*) *(COMMON) . = ALIGN(4); bss_end = .; } > ram
  stack_top = ORIGIN(ram) + LENGTH(ram);
}
"""


def missing():
    """The first tool that is not there, or None."""
    return next((tool for tool in TOOLS if shutil.which(tool) is None), None)


def linked(folder, sources, includes, board="cortex-m4", level="-Os", more=()):
    """An image of `run`, which the sources define."""
    folder = Path(folder)
    (folder / "start.c").write_text(START)
    (folder / "layout.ld").write_text(LAYOUT)
    command = [
        "arm-none-eabi-gcc", "-std=gnu99", level, *BOARDS[board][1].split(), *FLAGS.split(), *more,
        *(f"-I{path}" for path in includes), *sources, folder / "start.c", "-nostartfiles",
        "-Wl,--gc-sections", f"-T{folder / 'layout.ld'}", "-o", folder / "image.elf",
    ]  # fmt: skip
    subprocess.run(command, check=True, capture_output=True)
    return folder / "image.elf"


def run(image, board="cortex-m4", seconds=120):
    """(status, text) of an image."""
    command = [
        "qemu-system-arm", "-M", BOARDS[board][0], "-nographic", "-semihosting",
        "-icount", "shift=0", "-monitor", "none", "-serial", "none", "-kernel", image,
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=seconds, check=False)
    return done.returncode, done.stdout + done.stderr
