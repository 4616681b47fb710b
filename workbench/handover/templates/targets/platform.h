#include <stddef.h>
#include <stdint.h>

void platform_start(void);
void platform_read(void *to, size_t bytes);
void platform_write(const void *from, size_t bytes);
uint32_t platform_ticks(void);   /* counts up, and begins again behind its last number */
void platform_paint(void);       /* marks the stack that is free */
uint64_t platform_depth(void);   /* bytes of it that have changed since */
void platform_end(void);
