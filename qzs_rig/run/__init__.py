"""One run: stages, performed in process, sheet, folder, bag; and a bag analysed later."""
