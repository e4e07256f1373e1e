# Installs what web/package-lock.json lists, if that is not done: cmake -DWEB=web -DNPM=npm -P install.cmake
# Builds of several presets share web/node_modules; `npm ci` empties it first, while another build may use it.
set(installed ${WEB}/node_modules/.package-lock.json)
file(LOCK ${WEB}/.npm.lock GUARD PROCESS TIMEOUT 600)
if(EXISTS ${installed} AND ${installed} IS_NEWER_THAN ${WEB}/package-lock.json)
  file(TOUCH_NOCREATE ${installed})
  return()
endif()
file(REMOVE ${installed})  # so that a run that is killed is not taken for a finished one
execute_process(COMMAND ${NPM} ci --no-audit --no-fund --loglevel=error WORKING_DIRECTORY ${WEB}
  COMMAND_ERROR_IS_FATAL ANY)
