# SUNSET in a container, by the README's first commands. docs/containers.md says how to use it, and what was tried of it.
FROM debian:bookworm-slim
RUN apt-get update && apt-get install -y --no-install-recommends ca-certificates git python3 python3-venv
RUN useradd --create-home user && install -d -o user /home/user/sunset
USER user
WORKDIR /home/user/sunset
COPY --chown=user . .
RUN python3 -m venv .venv && . .venv/bin/activate && pip install ./packages/ros '.[live,plots]'
ENV PATH=/home/user/sunset/.venv/bin:$PATH
CMD ["sunset", "run"]
