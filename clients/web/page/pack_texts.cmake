# Puts NAME.gz beside every text of the page in FOLDER, for haptic-web to send to browsers that accept it. The same text gives the same bytes: gzip -n
# keeps neither name nor time. The file has the time of the text, by which haptic-web knows that it is of that text.
find_program(GZIP gzip REQUIRED)
file(GLOB_RECURSE texts "${FOLDER}/*.html" "${FOLDER}/*.js" "${FOLDER}/*.css" "${FOLDER}/*.json" "${FOLDER}/*.svg" "${FOLDER}/*.wasm")
execute_process(COMMAND "${GZIP}" -9nkf ${texts} COMMAND_ERROR_IS_FATAL ANY)
