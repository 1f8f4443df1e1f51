/* The colours of every plot, red, green and blue from 0 to 1: those of Okabe and Ito (Color Universal
 * Design, 2008), which readers with any colour vision can tell apart. Where two lines share a panel, a
 * dash or a shape says the same without colour. The report's style sheet repeats them. */
#ifndef HL_CLI_PALETTE_H
#define HL_CLI_PALETTE_H

#define HL_BLUE 0, 0.447, 0.698
#define HL_SKY_BLUE 0.337, 0.706, 0.914
#define HL_GREEN 0, 0.62, 0.451
#define HL_ORANGE 0.902, 0.624, 0
#define HL_VERMILLION 0.835, 0.369, 0

/* Text, a grey channel and the lines of a grid. */
#define HL_TEXT_GREY 0.1, 0.1, 0.1
#define HL_DATA_GREY 0.2, 0.2, 0.2
#define HL_GRID_GREY 0.88, 0.88, 0.88

#endif
